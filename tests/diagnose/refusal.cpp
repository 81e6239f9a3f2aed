// SPDX-License-Identifier: BSD-3-Clause
// Answers where the library does not have the whole truth.
#include "beam_generator/random_case.hpp"
#include "diagnosis_records.hpp"

#include <algorithm>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace culm::tests {
namespace {

/// A curved stem with internal friction at twenty times the noise; the friction is not among the
/// candidates, and one effect at most is named. The recording shows the family of the friction and
/// not its law.
TEST(Answer, IsAFamilyWhoseLawIsNotAmongTheCandidates) {
    const beam::RandomCase hidden = beam::random_case(9, beam::CaseKind::Pair, 13);
    ASSERT_EQ(hidden.spec.effects.front().name, "precurvature");
    const std::vector<measure::Measurement> recordings{beam::record(hidden.spec)};
    diagnose::DiagnosisOptions options = quick_diagnosis("relaxation,precurvature,camera_tilt");
    options.most_effects = 1;
    const diagnose::Diagnosis found =
        diagnose::diagnose(diagnose::specimens_of(recordings), options);
    EXPECT_EQ(found.conclusion, diagnose::Conclusion::Effect) << found.reason;
    ASSERT_EQ(found.families.size(), 1U);
    EXPECT_EQ(found.families.front().family, physics::Family::MaterialDamping);
    EXPECT_TRUE(found.families.front().is_open);
    EXPECT_EQ(found.ladder.back().verdict.finding, diagnose::Finding::Inadequate);
}

/// Drag and a slight taper; the taper is not among the candidates.
diagnose::Diagnosis with_taper(double relative_change) {
    beam::RecordingSpec spec;
    spec.id = "drag";
    spec.heights = beam::even_heights(spec.stem.length, 8);
    spec.duration = 0.35;
    spec.errors.noise = 0.021e-3;
    spec.effects = {{"quadratic_drag", {{"drag_coefficient", 1.5}}},
                    {"taper", {{"relative_change", relative_change}}}};
    const std::vector<measure::Measurement> recordings{beam::record(spec)};
    diagnose::DiagnosisOptions options = quick_diagnosis("quadratic_drag");
    return diagnose::diagnose(diagnose::specimens_of(recordings), options);
}

// The misfit is a few times the noise, and its share is known to a fraction of a percent.
TEST(Answer, IsGivenWithTheUnexplainedShareDespiteALittleStructure) {
    const diagnose::Diagnosis found = with_taper(0.15);
    EXPECT_EQ(found.conclusion, diagnose::Conclusion::Effect) << found.reason;
    EXPECT_LT(found.baseline.reduced_chi_squared, 25.0);
    EXPECT_EQ(found.ladder.back().verdict.finding, diagnose::Finding::Inadequate);
    EXPECT_GT(found.unexplained, 0.0);
    const diagnose::Diagnosis half = with_taper(0.3);
    EXPECT_EQ(half.conclusion, diagnose::Conclusion::Unknown) << half.reason;
}

// A chain that does not move leaves the whole motion. Were that its misfit, an effect that moves it
// at all would explain nearly everything, however wrong its law is.
TEST(ExplainedShare, CountsAChainThatDoesNotMoveAsOneThatFollowsTheMotion) {
    const auto fit_of = [](double chi_squared, double rmse) {
        fit::Fit fit;
        fit.readings = 1000;
        fit.chi_squared = chi_squared;
        fit.misfits = {{1000, chi_squared, rmse, true, 5e-3}};
        return fit;
    };
    const fit::Fit still = fit_of(1e7, 5e-3);
    const fit::Fit moved = fit_of(17e3, 0.2e-3); // four times the noise
    // A fifth of the motion is a 25th of χ².
    EXPECT_NEAR(diagnose::explained_share(moved, still), 1.0 - 16e3 * 25.0 / 1e7, 1e-4);
    const fit::Fit followed = fit_of(4e5, 1e-3);
    EXPECT_NEAR(diagnose::explained_share(moved, followed), 1.0 - 16.0 / 399.0, 1e-9);
}

} // namespace
} // namespace culm::tests
