// SPDX-License-Identifier: BSD-3-Clause
#include "calibrate/first_mode.hpp"

#include "core/error.hpp"
#include "run/case_model.hpp"

#include <cmath>
#include <numbers>
#include <vector>

#include <fmt/core.h>

namespace culm::calibrate {

ModeOfChain first_mode(const run::CaseSpec& spec) {
    run::CaseSpec bare = spec;
    bare.effects.clear();
    const physics::Chain<2, double> chain(bare.stem.sphere_count, run::case_model(bare).chain,
                                          bare.law);
    const std::vector<integrate::VibrationMode> modes =
        integrate::vibration_modes(integrate::linearise_transverse(chain), 1);
    if (modes.empty())
        throw core::NumericalError(
            core::FailureKind::FitFailed,
            fmt::format("the chain with Y = {:.6g} Pa and beta = {:.6g} does not vibrate",
                        bare.stem.bond_youngs_modulus, bare.stem.bond_damping));
    ModeOfChain mode;
    mode.frequency = modes.front().frequency;
    mode.decay_per_cycle = modes.front().decay_per_cycle;
    const double decay = -mode.decay_per_cycle / (2.0 * std::numbers::pi);
    mode.damping_ratio = decay / std::hypot(1.0, decay);
    mode.natural_frequency = mode.frequency * std::hypot(1.0, decay);
    return mode;
}

} // namespace culm::calibrate
