// SPDX-License-Identifier: BSD-3-Clause
// The chain linearised about a state at rest: modes, decay, and the largest stable explicit step.
#pragma once

#include "physics/chain.hpp"

#include <complex>
#include <vector>

#include <Eigen/Core>

namespace culm::integrate {

/// M ü + C u̇ + K u = 0 for small displacements and rotations u of the moving spheres.
/// Each sphere contributes its Dim displacements, then its 1 (planar) or 3 rotations, from the
/// clamp to the tip. Forces that follow bond histories are stiffness here: the histories'
/// increments are linear in u. K and C need not be symmetric (law "schramm2019").
struct LinearisedChain {
    Eigen::VectorXd mass;      ///< (dof), diagonal of M, kg and kg m²
    Eigen::MatrixXd damping;   ///< (dof, dof)
    Eigen::MatrixXd stiffness; ///< (dof, dof)
};

/// Linearises about `state`, which must be at rest. The derivatives are exact. If an effect lets
/// the clamp turn, its rotation is the first of the freedoms; Maxwell branches count as relaxed.
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

/// Eigenvalues λ (1/s) of the linearised chain, u ~ exp(λt), sorted by magnitude, slowest first.
/// Slow ones are computed from the inverse of the companion matrix, in which they dominate: their
/// relative error stays near rounding although the fastest are larger by eight orders.
[[nodiscard]] std::vector<std::complex<double>> eigenvalues(const LinearisedChain& chain);

/// One vibration mode.
struct VibrationMode {
    double frequency;       ///< Im λ/2π, Hz: b2 of Eq. 1
    double decay_rate;      ///< Re λ, 1/s: b1 of Eq. 1, negative
    double decay_per_cycle; ///< decay_rate/frequency
};

/// The vibrating modes (complex pairs), slowest first, `count` of them at most.
[[nodiscard]] std::vector<VibrationMode> vibration_modes(const LinearisedChain& chain,
                                                         std::size_t count);

/// The lowest natural frequency of the chain without its damping, Hz, by inverse iteration: a small
/// part of what all modes cost. NaN if the stiffness is singular or the chain leans further.
[[nodiscard]] double lowest_natural_frequency(const LinearisedChain& chain);

/// The largest step (s) for which velocity Verlet, with damping evaluated from the half-step
/// velocity, is stable for the linearised chain: the one-step map's spectral radius is 1 there.
[[nodiscard]] double largest_stable_step(const LinearisedChain& chain);

} // namespace culm::integrate
