// SPDX-License-Identifier: BSD-3-Clause
// The chain linearised about a state at rest; modes.hpp finds how it vibrates.
#pragma once

#include "physics/chain.hpp"

#include <vector>

#include <Eigen/Core>

namespace culm::integrate {

/// M ü + C u̇ + K u = 0 for small displacements and rotations u of the moving spheres.
/// Each sphere contributes its Dim displacements, then its 1 (planar) or 3 rotations, from the
/// clamp to the tip. Forces from bond histories are part of the stiffness: the histories'
/// increments are linear in u. K and C need not be symmetric (law "schramm2019").
struct LinearisedChain {
    Eigen::VectorXd mass;      ///< (dof), diagonal of M, kg and kg m²
    Eigen::MatrixXd damping;   ///< (dof, dof)
    Eigen::MatrixXd stiffness; ///< (dof, dof)
};

/// Linearises about `state`, which must be at rest. The derivatives are exact. If an effect lets
/// the clamp turn, its rotation is the first degree of freedom. Maxwell branches count as relaxed.
template <int Dim>
[[nodiscard]] LinearisedChain linearise(const physics::Chain<Dim, double>& chain,
                                        const std::vector<double>& state);

/// The transverse motion (lateral displacement and rotation about z) of the straight planar chain,
/// which does not couple with the axial one.
[[nodiscard]] LinearisedChain linearise_transverse(const physics::StemParameters<double>& stem,
                                                   const physics::BondLawOptions& law);

/// The same of a chain with effects, the clamp's rotation included if it turns. `chain` lies in the
/// plane.
[[nodiscard]] LinearisedChain linearise_transverse(const physics::Chain<2, double>& chain);

/// The axial motion of the straight planar chain.
[[nodiscard]] LinearisedChain linearise_axial(const physics::StemParameters<double>& stem,
                                              const physics::BondLawOptions& law);

} // namespace culm::integrate
