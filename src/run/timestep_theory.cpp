// SPDX-License-Identifier: BSD-3-Clause
#include "run/timestep_theory.hpp"

#include <cmath>

namespace culm::run {

double bond_time(const physics::StemParameters<double>& stem) {
    const double stiffness = stem.bond_youngs_modulus * stem.section_area() / stem.bond_length;
    return std::sqrt(stem.sphere_mass() / stiffness);
}

double published_timestep_rule(const physics::StemParameters<double>& stem) {
    return 0.95 / (1.1 + 2.9 * stem.bond_damping) * bond_time(stem);
}

double cantilever_period(const physics::StemParameters<double>& stem) {
    const double bending = stem.bond_youngs_modulus * stem.second_moment_of_area();
    const double mass_per_length = stem.sphere_mass() / stem.bond_length;
    const double length = stem.free_length();
    constexpr double frequency_factor = 0.5596; // 1.8751²/2π
    return length * length / (frequency_factor * std::sqrt(bending / mass_per_length));
}

TimestepLimits timestep_limits(const CaseSpec& spec) {
    return {integrate::largest_stable_step(integrate::linearise_transverse(spec.stem, spec.law)),
            integrate::largest_stable_step(integrate::linearise_axial(spec.stem, spec.law)),
            published_timestep_rule(spec.stem)};
}

double undamped_period(const CaseSpec& spec) {
    physics::StemParameters<double> stem = spec.stem;
    stem.bond_damping = 0.0;
    const auto modes =
        integrate::vibration_modes(integrate::linearise_transverse(stem, spec.law), 1);
    return 1.0 / modes.front().frequency;
}

std::optional<integrate::FirstModeStepError> step_error(const CaseSpec& spec) {
    return integrate::FirstModeStepError::of(integrate::linearise_transverse(spec.stem, spec.law));
}

} // namespace culm::run
