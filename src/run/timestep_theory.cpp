// SPDX-License-Identifier: BSD-3-Clause
#include "run/timestep_theory.hpp"

#include "integrate/modes.hpp"

#include <cmath>

namespace culm::run {

double bond_time(const physics::StemParameters<double>& stem) {
    // √(m/K) with the axial stiffness K = Y A/l of a bond: a wave passes one bond in that time.
    const double stiffness = stem.bond_youngs_modulus * stem.section_area() / stem.bond_length;
    return std::sqrt(stem.sphere_mass() / stiffness);
}

double published_timestep_rule(const physics::StemParameters<double>& stem) {
    return 0.95 / (1.1 + 2.9 * stem.bond_damping) * bond_time(stem);
}

TimestepLimits timestep_limits(const CaseSpec& spec) {
    return {integrate::largest_stable_step(integrate::linearise_transverse(spec.stem, spec.law)),
            integrate::largest_stable_step(integrate::linearise_axial(spec.stem, spec.law)),
            published_timestep_rule(spec.stem)};
}

std::optional<integrate::FirstModeStepError> step_error(const CaseSpec& spec) {
    return integrate::FirstModeStepError::of(integrate::linearise_transverse(spec.stem, spec.law));
}

} // namespace culm::run
