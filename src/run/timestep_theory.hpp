// SPDX-License-Identifier: BSD-3-Clause
// What theory says about the explicit step of a stem, before any run.
#pragma once

#include "integrate/step_error.hpp"
#include "run/case_spec.hpp"

#include <optional>

namespace culm::run {

/// Limits of the explicit step, s.
struct TimestepLimits {
    double transverse;     ///< largest stable step of the linearised chain's transverse motion
    double axial;          ///< … of its axial motion
    double published_rule; ///< see published_timestep_rule

    [[nodiscard]] double linearised() const { return transverse < axial ? transverse : axial; }
};

[[nodiscard]] TimestepLimits timestep_limits(const CaseSpec& spec);

/// √(m/k_n), s: the natural unit of the step. Every limit divided by it depends on β, the law and
/// the shape of a bond, not on Y or the density.
[[nodiscard]] double bond_time(const physics::StemParameters<double>& stem);

/// The rule of the paper's authors, 0.95/((1.1 + 2.9β)√(k_n/m)) with a bond's normal stiffness and
/// a sphere's mass, s. It contains a safety factor.
[[nodiscard]] double published_timestep_rule(const physics::StemParameters<double>& stem);

/// What a step does to the first mode; nothing if the linearised stem creeps back without swinging.
[[nodiscard]] std::optional<integrate::FirstModeStepError> step_error(const CaseSpec& spec);

} // namespace culm::run
