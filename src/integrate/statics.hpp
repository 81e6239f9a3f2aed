// SPDX-License-Identifier: BSD-3-Clause
// The equilibrium of a clamped stem whose tip is held at a given deflection.
#pragma once

#include "physics/chain.hpp"

#include <vector>

namespace culm::integrate {

/// A chain at rest.
struct StaticState {
    std::vector<double> state; ///< in the chain's layout, velocities zero
    double holding_force;      ///< lateral force on the tip that keeps it there, N
};

/// The equilibrium of a clamped chain whose tip centre is displaced laterally (axis 1) by
/// `tip_deflection` (m, either sign) and is otherwise free, gravity included. Large deflections
/// are followed from the straight state in load steps; the bond histories are integrated along the
/// way with the same rates as in motion, at the middle of each step, so that they differ from the
/// exact path integral by the square of a step's rotation over 24 (below 1e-5 relative).
/// `lateral_loads`: further forces on the spheres, N; empty: none. Throws
/// core::NumericalError(StaticFailed) when no equilibrium is found.
template <int Dim>
[[nodiscard]] StaticState deflected_equilibrium(const physics::Chain<Dim, double>& chain,
                                                double tip_deflection,
                                                std::span<const double> lateral_loads = {});

} // namespace culm::integrate
