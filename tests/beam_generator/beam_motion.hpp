// SPDX-License-Identifier: BSD-3-Clause
// The motion of a beam that is held aside at its tip and released.
#pragma once

#include "beam_generator/beam_model.hpp"

#include <vector>

#include <Eigen/Core>

namespace culm::beam {

struct HeldBeam {
    Eigen::VectorXd q;
    double finger_force = 0.0; ///< on the tip, sideways, N
};

/// The equilibrium with the tip's deflection given (m). Throws core::NumericalError (StaticFailed).
[[nodiscard]] HeldBeam held_at_tip(const BeamModel& model, double tip_deflection);

/// Coordinates and velocities at equal intervals from the release on.
struct BeamMotion {
    double step = 0.0; ///< s
    std::vector<Eigen::VectorXd> q;
    std::vector<Eigen::VectorXd> v;

    [[nodiscard]] double end() const { return step * static_cast<double>(q.size() - 1); }
    /// Coordinates at `time` (s): Hermite's cubic; before the release those of the held beam.
    [[nodiscard]] Eigen::VectorXd coordinates(double time) const;
};

/// 1/120 of the first period; 1/400 with dry friction and 1/800 with a stop, which act abruptly.
[[nodiscard]] double default_step(const BeamModel& model);

/// Free motion of at least `duration` (s) with the five-stage diagonally implicit method of order 4
/// that damps the stiff modes (SDIRK, Hairer & Wanner, Solving ODEs II, table IV.6.5). Throws
/// core::NumericalError (SolverFailed) if a stage does not converge.
[[nodiscard]] BeamMotion release(const BeamModel& model, const HeldBeam& held, double duration,
                                 double step);

} // namespace culm::beam
