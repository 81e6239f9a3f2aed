// SPDX-License-Identifier: BSD-3-Clause
#include "calibrate/first_mode.hpp"

#include "calibrate/stem_chain.hpp"
#include "core/error.hpp"
#include "run/case_model.hpp"

#include <cmath>
#include <numbers>
#include <vector>

#include <fmt/core.h>

namespace culm::calibrate {
namespace {

constexpr double little_damping = 1e-3; // β of a chain that vibrates

} // namespace

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

double lowest_frequency_with_effects(const run::CaseSpec& spec) {
    run::CaseSpec planar = spec;
    planar.dimensions = 2;
    std::erase_if(planar.effects,
                  [](const auto& active) { return active.effect->dimensions() > 2; });
    const physics::Chain<2, double> chain(planar.stem.sphere_count, run::case_model(planar).chain,
                                          planar.law);
    return integrate::lowest_natural_frequency(integrate::linearise_transverse(chain));
}

double natural_frequency(const run::CaseSpec& spec) {
    if (spec.added_masses.empty())
        return beam_frequency(spec);
    run::CaseSpec loaded = spec;
    loaded.stem.bond_damping = little_damping;
    run::CaseSpec bare = loaded;
    bare.added_masses.clear();
    return beam_frequency(spec) * first_mode(loaded).natural_frequency /
           first_mode(bare).natural_frequency;
}

} // namespace culm::calibrate
