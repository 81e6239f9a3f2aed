// SPDX-License-Identifier: BSD-3-Clause
// Synthetic recordings: noise, gaps and reproducibility.
#include "beam_generator/random_case.hpp"
#include "beam_generator/random_effect.hpp"
#include "core/error.hpp"
#include "measure/folder/measurement_folder.hpp"
#include "physics/effects/library.hpp"
#include "support/temporary_folder.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

namespace culm::beam {
namespace {

RecordingSpec short_recording() {
    RecordingSpec spec;
    spec.heights = even_heights(spec.stem.length, 10);
    spec.duration = 0.3;
    return spec;
}

/// Readings of `noisy` less those of the same recording without errors.
std::vector<double> errors_of(const RecordingSpec& noisy) {
    RecordingSpec clean = noisy;
    clean.errors = {};
    std::vector<double> difference = record(noisy).deflections;
    const std::vector<double> truth = record(clean).deflections;
    for (std::size_t k = 0; k < truth.size(); ++k)
        difference[k] -= truth[k];
    return difference;
}

TEST(Recording, HasTheNoiseThatWasAskedFor) {
    RecordingSpec spec = short_recording();
    spec.errors.noise = 5e-5;
    spec.errors.correlation = 0.6;
    const std::vector<double> errors = errors_of(spec);
    const std::size_t rows = spec.heights.size();
    double square = 0.0;
    double product = 0.0;
    for (std::size_t k = 0; k < errors.size(); ++k)
        square += errors[k] * errors[k];
    for (std::size_t k = rows; k < errors.size(); ++k)
        product += errors[k] * errors[k - rows];
    const double count = static_cast<double>(errors.size());
    // 3070 readings, correlated over about 4 frames: standard errors of 2.2 % and 0.015.
    EXPECT_NEAR(std::sqrt(square / count), 5e-5, 0.08 * 5e-5);
    EXPECT_NEAR(product / square, 0.6, 0.06);
}

TEST(Recording, LosesReadingsAndRoundsTheOthers) {
    RecordingSpec spec = short_recording();
    spec.errors.missing_share = 0.1;
    spec.errors.quantum = 1e-4;
    const measure::Measurement measurement = record(spec);
    std::size_t missing = 0;
    for (const double reading : measurement.deflections) {
        if (std::isnan(reading)) {
            ++missing;
            continue;
        }
        const double steps = reading / 1e-4;
        EXPECT_NEAR(steps, std::round(steps), 1e-9);
    }
    // Binomial: a standard deviation of 0.0054.
    EXPECT_NEAR(static_cast<double>(missing) / static_cast<double>(measurement.deflections.size()),
                0.1, 0.025);
}

TEST(Recording, ShowsTheHeldStemBeforeTheRelease) {
    RecordingSpec spec = short_recording();
    spec.frames_before = 5;
    const measure::Measurement measurement = record(spec);
    EXPECT_LT(measurement.times.front(), -4e-3);
    for (std::size_t row = 0; row < spec.heights.size(); ++row)
        for (std::size_t frame = 0; frame <= 5; ++frame)
            EXPECT_EQ(measurement.deflection(frame, row), measurement.deflection(5, row));
}

TEST(Recording, IsUnchangedByWritingAndReading) {
    const tests::TemporaryFolder folder;
    RandomCase drawn = random_case(3, CaseKind::Single, 5);
    drawn.spec.errors.missing_share = 0.02;
    const measure::Measurement measurement = record(drawn.spec);
    measure::write_measurement(folder.path() / "made-up", measurement);
    const measure::Measurement back = measure::read_measurement(folder.path() / "made-up");
    ASSERT_EQ(back.deflections.size(), measurement.deflections.size());
    for (std::size_t k = 0; k < back.deflections.size(); ++k)
        if (!std::isnan(measurement.deflections[k])) {
            EXPECT_EQ(back.deflections[k], measurement.deflections[k]);
        }
    EXPECT_EQ(back.stem.length, measurement.stem.length);
}

TEST(RandomCase, FollowsFromItsSeedAndNumberAlone) {
    const auto one = record(random_case(11, CaseKind::Pair, 4).spec);
    static_cast<void>(random_case(11, CaseKind::Null, 0));
    const auto again = record(random_case(11, CaseKind::Pair, 4).spec);
    EXPECT_EQ(one.deflections, again.deflections);
    EXPECT_NE(record(random_case(12, CaseKind::Pair, 4).spec).deflections, one.deflections);
    EXPECT_NE(random_case(11, CaseKind::Null, 4).spec.seed,
              random_case(11, CaseKind::Pair, 4).spec.seed);
}

TEST(RandomCase, CoversEveryEffectOfTheLibrary) {
    std::vector<std::string> names = library_effects();
    std::ranges::copy(further_effects(), std::back_inserter(names));
    std::vector<std::string> culms;
    for (const physics::EffectPointer& effect : physics::all_effects())
        // A law that contains others is drawn as one of them.
        if (effect->name != "power_drag" && effect->name != "fractional_zener")
            culms.push_back(effect->name);
    std::ranges::sort(names);
    std::ranges::sort(culms);
    EXPECT_EQ(names, culms);
}

TEST(RandomCase, HasParametersOfCulmsNamesWithinCulmsBounds) {
    for (std::uint64_t number = 0; number < 74; ++number) {
        const RandomCase drawn = number < 54 ? random_case(5, CaseKind::Single, number)
                                             : random_case(5, CaseKind::Further, number);
        const HiddenEffect& hidden = drawn.spec.effects.front();
        for (const auto& parameter : physics::effect_named(hidden.name)->parameters) {
            EXPECT_GE(hidden.value(parameter.name), parameter.lower) << hidden.name;
            EXPECT_LE(hidden.value(parameter.name), parameter.upper) << hidden.name;
        }
    }
}

TEST(RandomCase, CanBeRecordedInEveryKind) {
    for (const CaseKind kind :
         {CaseKind::Null, CaseKind::Pair, CaseKind::Unknown, CaseKind::Further})
        for (std::uint64_t number = 0; number < 5; ++number) {
            const measure::Measurement measurement = record(random_case(2, kind, number).spec);
            // A stem that is pulled by 25 mm still reaches the highest row.
            for (std::size_t frame = 0; frame < measurement.times.size(); ++frame)
                EXPECT_FALSE(
                    std::isnan(measurement.deflection(frame, measurement.heights.size() - 1)));
        }
}

TEST(LawErrors, ChangeTheEffectThatTheyBelongTo) {
    LawErrors errors;
    errors.drag_exponent = 1.7;
    errors.drag_speed = 2.0;
    errors.clamp_loss_factor = 0.1;
    errors.relaxation = {{0.6, 1.0}, {0.4, 5.0}};
    const BeamStem stem;
    const BeamTerms none = hidden_physics(stem, {}, errors).terms;
    EXPECT_FALSE(none.power_drag || none.clamp || none.second_mode || !none.branches.empty());
    const BeamTerms nominal =
        hidden_physics(stem, {{"quadratic_drag", {{"drag_coefficient", 1.2}}}}).terms;
    const BeamTerms terms =
        hidden_physics(
            stem,
            {{"quadratic_drag", {{"drag_coefficient", 1.2}}},
             {"clamp_compliance", {{"stiffness_nm_rad", 3.0}}},
             {"relaxation", {{"fraction", 0.02}, {"time_s", 0.01}, {"hold_time_s", 0.1}}}},
            errors)
            .terms;
    ASSERT_TRUE(terms.power_drag && terms.clamp);
    EXPECT_EQ(terms.quadratic_drag, 0.0);
    // The same force at the speed of 2 m/s.
    EXPECT_NEAR(terms.power_drag->coefficient * std::pow(2.0, 1.7), 4.0 * nominal.quadratic_drag,
                1e-12);
    EXPECT_NEAR(terms.clamp->damping * 2.0 * std::numbers::pi * stem.first_frequency(), 0.3, 1e-12);
    ASSERT_EQ(terms.branches.size(), 2u);
    EXPECT_NEAR(terms.branches[0].fraction, 0.012, 1e-15);
    EXPECT_NEAR(terms.branches[1].time, 0.05, 1e-15);
    EXPECT_NEAR(terms.branches[1].held_share, std::exp(-2.0), 1e-12);
}

TEST(HiddenEffect, IsRefusedWithAnUnknownNameOrWithoutParameters) {
    EXPECT_THROW(static_cast<void>(hidden_physics({}, {{"quadratic_darg", {}}})), core::InputError);
    EXPECT_THROW(static_cast<void>(hidden_physics({}, {{"taper", {}}})), core::InputError);
}

} // namespace
} // namespace culm::beam
