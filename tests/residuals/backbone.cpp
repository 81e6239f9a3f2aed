// SPDX-License-Identifier: BSD-3-Clause
// The class of the hidden effect from the backbone alone, on made-up recordings.
#include "beam_generator/random_effect.hpp"
#include "beam_generator/recording.hpp"
#include "residuals/swing.hpp"

#include <algorithm>
#include <numbers>
#include <string>

#include <fmt/core.h>
#include <gtest/gtest.h>

namespace culm::residuals {
namespace {

using reduce::AmplitudeClass;

struct KnownSignature {
    std::string effect;
    AmplitudeClass wanted;
};

const std::vector<KnownSignature> signatures{
    {"viscous_drag", AmplitudeClass::Linear},
    {"clamp_compliance", AmplitudeClass::Linear},
    {"clamp_friction", AmplitudeClass::Friction},
    {"quadratic_drag", AmplitudeClass::Drag},
    {"amplitude_damping", AmplitudeClass::Drag},
    {"plate_air", AmplitudeClass::EdgesSlip},
    {"clamp_slip", AmplitudeClass::EdgesSlip},
    {"bending_nonlinearity", AmplitudeClass::Stiffness},
};

/// A lightly damped stem, or a strip for an effect of edges, with one effect of random strength; 60
/// to 90 cycles at 14 to 30 frames a cycle.
beam::RecordingSpec recording_with(const std::string& effect, std::uint64_t number) {
    beam::Dice dice({7, beam::RandomUse::CaseDraw, number, 0});
    beam::RecordingSpec spec;
    spec.id = fmt::format("{}-{}", effect, number);
    beam::BeamStem& stem = spec.stem;
    stem.length = dice.between(0.14, 0.18);
    stem.diameter = dice.between(2.4e-3, 3.4e-3);
    stem.density = dice.between(100.0, 180.0);
    stem.youngs_modulus = dice.log_between(1.2e9, 3.5e9);
    if (effect == "plate_air") {
        stem = {0.3, 1.5e-3, 1200.0, 3e9, 0.0, dice.between(0.03, 0.05)};
        stem.length = dice.between(0.25, 0.4);
    }
    stem.damping_time =
        dice.log_between(0.002, 0.008) / (std::numbers::pi * stem.first_frequency());
    spec.tip_deflection = stem.length * dice.between(0.06, 0.12);
    spec.heights = beam::even_heights(stem.length, dice.whole(3, 10));
    spec.frames_per_second = stem.first_frequency() * dice.between(14.0, 30.0);
    spec.duration = dice.between(60.0, 90.0) / stem.first_frequency();
    spec.errors.noise = spec.tip_deflection * dice.log_between(1e-3, 4e-3);
    spec.seed = number;
    spec.effects = {beam::random_effect(
        effect, {stem, spec.tip_deflection, spec.hold_time, spec.gravity_direction}, dice)};
    return spec;
}

TEST(Backbone, ShowsTheClassOfTheHiddenEffect) {
    int right = 0;
    int all = 0;
    std::string wrong;
    for (const KnownSignature& known : signatures)
        for (std::uint64_t number = 1; number <= 5; ++number, ++all) {
            const auto spec = recording_with(known.effect, number);
            const auto found = reduce::backbones(backbone_input(beam::record(spec)), 2);
            const bool is_right = !found.empty() && found.front().signature == known.wanted;
            right += is_right ? 1 : 0;
            if (!is_right)
                wrong += fmt::format("{}: {}\n", spec.id,
                                     found.empty() || !found.front().signature
                                         ? "no class"
                                         : to_string(*found.front().signature));
        }
    EXPECT_EQ(all, 40);
    EXPECT_GE(right, 36) << wrong;
}

/// ζ = ζ0 + ζ1 A/A0 damps the amplitude by dA/dt = −ω ζ A, which has a closed solution. A window of
/// eight cycles loses more than half of its amplitude.
TEST(Backbone, FindsThePowerOfAFastDecay) {
    constexpr double omega = 2.0 * std::numbers::pi * 80.0;
    constexpr double linear = 0.016;
    constexpr double quadratic = 0.02;
    reduce::BackboneInput input{{{}, {{}}, {1.0}}, {0.1}, {0}};
    for (double time = 0.0; time < 0.4; time += 1e-3) {
        const double amplitude =
            linear / ((linear + quadratic) * std::exp(omega * linear * time) - quadratic);
        input.histories.times.push_back(time);
        input.histories.histories.front().push_back(10e-3 * amplitude * std::cos(omega * time));
    }
    const auto found = reduce::backbones(input, 1);
    ASSERT_FALSE(found.empty());
    ASSERT_TRUE(found.front().laws && found.front().laws->power_exponent);
    EXPECT_NEAR(found.front().laws->power_exponent->value, 1.0, 0.1);
    EXPECT_NEAR(found.front().laws->linear->value, linear, 0.02 * linear);
}

} // namespace
} // namespace culm::residuals
