// SPDX-License-Identifier: BSD-3-Clause
#include "diagnose/ladder.hpp"

#include "beam_generator/recording.hpp"
#include "diagnosis_records.hpp"
#include "support/parameter_ids.hpp"
#include "support/single_fit.hpp"

#include <gtest/gtest.h>

namespace culm::tests {
namespace {

std::vector<fit::SelectedEffects> models(std::initializer_list<const char*> texts) {
    std::vector<fit::SelectedEffects> all;
    for (const char* const text : texts)
        all.push_back(physics::parse_effects(text, {}));
    return all;
}

double over_noise(const diagnose::Ladder& ladder, std::size_t model) {
    const fit::RecordingFit& fit = ladder.models[model].fit.parts.front();
    return fit.rmse / fit::typical_noise(fit);
}

TEST(Ladder, EndsAtTheNoiseWithTheTrueCoefficientForARecordWithDrag) {
    const diagnose::Ladder ladder = diagnose::climb(recording("T2-quadratic_drag").front(),
                                                    models({"quadratic_drag"}), quick_fit());
    ASSERT_FALSE(ladder.models[1].fit.failed()) << ladder.models[1].why;
    EXPECT_GT(over_noise(ladder, 0), 3.0);
    EXPECT_LT(over_noise(ladder, 1), 1.10);
    EXPECT_TRUE(ladder.models[1].is_gain) << ladder.models[1].why;
    const auto* drag =
        ladder.models[1].fit.parts.front().find(id("quadratic_drag.drag_coefficient"));
    ASSERT_NE(drag, nullptr);
    EXPECT_NEAR(drag->value, 1.3, 0.05); // the truth; issue 5 asks for 15 %
    EXPECT_EQ(ladder.models[0].comparison->verdict.finding, diagnose::Finding::Inadequate);
    EXPECT_EQ(ladder.models[1].comparison->verdict.finding, diagnose::Finding::Adequate)
        << ladder.models[1].comparison->verdict.reason;
    // Without drag the model's decay cannot follow the amplitude.
    const residuals::BackbonesOfBoth& backbones = ladder.models[0].comparison->backbones;
    const auto fall_of_damping = [](const std::vector<reduce::ModeBackbone>& of) {
        return of.at(0).points.front().damping_ratio / of.at(0).points.back().damping_ratio;
    };
    EXPECT_GT(fall_of_damping(backbones.measured), 1.5);
    EXPECT_NEAR(fall_of_damping(backbones.modelled), 1.0, 0.05);
}

TEST(Ladder, CallsAYieldingClampAGainButNotDrag) {
    const diagnose::Ladder ladder = diagnose::climb(
        recording("T3-clamp_compliance").front(),
        models({"clamp_compliance", "clamp_compliance,quadratic_drag"}), quick_fit());
    ASSERT_FALSE(ladder.models[1].fit.failed()) << ladder.models[1].why;
    EXPECT_TRUE(ladder.models[1].is_gain) << ladder.models[1].why;
    EXPECT_LT(over_noise(ladder, 1), 1.10);
    const auto* stiffness =
        ladder.models[1].fit.parts.front().find(id("clamp_compliance.stiffness_nm_rad"));
    ASSERT_NE(stiffness, nullptr);
    EXPECT_NEAR(stiffness->value, 0.6696, 0.15 * 0.6696); // the truth; issue 5 asks for 15 %
    EXPECT_FALSE(ladder.models[2].is_gain);
    EXPECT_FALSE(ladder.models[2].why.empty());
}

// Drag beside a shaking support: the linear estimate of both about the chain has negative drag, so
// that they have no start together.
TEST(Ladder, AddsOneEffectAfterTheOtherWhereBothHaveNoStart) {
    beam::RecordingSpec spec;
    spec.stem = {.length = 0.147, .diameter = 3.2e-3, .density = 100.0, .youngs_modulus = 1.65e9};
    spec.effects = {
        {"base_motion", {{"amplitude_m", 2e-4}, {"frequency_hz", 113.0}, {"phase_rad", -3.7}}},
        {"quadratic_drag", {{"drag_coefficient", 1.2}}}};
    spec.heights = beam::even_heights(spec.stem.length, 8);
    spec.duration = 0.2;
    spec.errors.noise = 0.05e-3;
    const diagnose::Ladder ladder =
        diagnose::climb(beam::record(spec), models({"base_motion,quadratic_drag"}), quick_fit());
    ASSERT_FALSE(ladder.models[1].fit.failed()) << ladder.models[1].why;
    EXPECT_GT(over_noise(ladder, 0), 3.0);
    EXPECT_LT(over_noise(ladder, 1), 1.5);
    EXPECT_TRUE(ladder.models[1].is_gain) << ladder.models[1].why;
}

TEST(Ladder, HasNoGainForAPlainRecord) {
    const diagnose::Ladder ladder =
        diagnose::climb(recording("T1-null").front(), models({"quadratic_drag"}), quick_fit());
    EXPECT_EQ(ladder.models[0].comparison->verdict.finding, diagnose::Finding::Adequate)
        << ladder.models[0].comparison->verdict.reason;
    EXPECT_FALSE(ladder.models[1].is_gain);
}

TEST(Ladder, ComparesAStepWithTheLikeliestModelBelow) {
    const diagnose::Ladder ladder = diagnose::climb(
        recording("T2-quadratic_drag").front(),
        models({"camera_tilt", "camera_tilt,quadratic_drag", "camera_tilt,quadratic_drag,gravity"}),
        quick_fit());
    ASSERT_EQ(ladder.models.size(), 4u);
    const diagnose::LadderModel& tilted = ladder.models[1];
    const diagnose::LadderModel& drag = ladder.models[2];
    ASSERT_FALSE(tilted.fit.failed() || drag.fit.failed()) << tilted.why << drag.why;
    EXPECT_FALSE(tilted.is_gain);
    EXPECT_EQ(tilted.compared_with, 0u);
    // The tilt lowered the evidence, so drag is compared with the baseline, with all that it
    // adds.
    EXPECT_TRUE(drag.is_gain) << drag.why;
    EXPECT_EQ(drag.compared_with, 0u);
    EXPECT_EQ(drag.added, (std::vector<std::string>{"quadratic_drag", "camera_tilt"}));
    EXPECT_LT(tilted.log_evidence, 0.0);
    EXPECT_DOUBLE_EQ(drag.log_evidence_gain, drag.log_evidence);
    const auto modulus = [&](std::size_t model) {
        const fit::RecordingFit& part = ladder.models[model].fit.parts.front();
        return part.model.spec.stem.bond_youngs_modulus;
    };
    EXPECT_DOUBLE_EQ(drag.modulus_change, modulus(2) / modulus(0) - 1.0);
    EXPECT_EQ(ladder.models[3].compared_with, 2u);
    EXPECT_FALSE(ladder.models[3].is_gain);
}

// The residual of a chain without friction also lies outside the spectral lines that the estimate
// of the noise omits, so there is no estimate. The readings have white noise of the stated 0.04 mm.
TEST(Ladder, UsesTheStatedNoiseWhereTheChainFailsClearly) {
    const measure::Measurement measurement = recording("T6-clamp_friction").front();
    const diagnose::Ladder ladder =
        diagnose::climb(measurement, models({"clamp_friction"}), quick_fit());
    for (const diagnose::LadderModel& model : ladder.models)
        EXPECT_EQ(model.fit.parts.front().noise_source, "stated");
    EXPECT_TRUE(ladder.models[1].is_gain) << ladder.models[1].why;
    EXPECT_EQ(ladder.models[1].comparison->verdict.finding, diagnose::Finding::Adequate)
        << ladder.models[1].comparison->verdict.reason;
}

// Started with both effects absent, a fit of the pair ends without drag and with an almost rigid
// clamp, at 5.84 times the noise; the clamp alone reaches 5.52.
TEST(FitLarger, FitsAPairNoWorseThanOneOfItsEffects) {
    const measure::Measurement measurement = recording("T6-clamp_friction").front();
    const fit::Fit baseline = fit_baseline(measurement, quick_fit());
    const fit::Fit clamp =
        fit_candidate(models({"clamp_compliance"}).front(), baseline, measurement, quick_fit());
    const fit::SelectedEffects both = models({"clamp_compliance,quadratic_drag"}).front();
    ASSERT_FALSE(clamp.failed()) << clamp.reason;
    const fit::Fit pair = fit_candidate(both, baseline, measurement, quick_fit());
    ASSERT_FALSE(pair.failed()) << pair.reason;
    EXPECT_LT(pair.rmse, 1.001 * clamp.rmse);
}

TEST(Verdict, IsUndecidedForAnExcerptOfOneCycle) {
    fit::FitOptions options = quick_fit();
    options.window = 0.015; // 1.3 cycles
    const measure::Measurement measurement = recording("T1-null").front();
    const fit::Fit fit = tests::fit_baseline(measurement, options);
    ASSERT_FALSE(fit.failed()) << fit.reason;
    const diagnose::Comparison comparison = diagnose::compare(fit, 0, measurement);
    EXPECT_EQ(comparison.verdict.finding, diagnose::Finding::Undecided);
    EXPECT_NE(comparison.verdict.reason.find("too few"), std::string::npos);
}

} // namespace
} // namespace culm::tests
