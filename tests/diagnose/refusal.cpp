// SPDX-License-Identifier: BSD-3-Clause
// A model that leaves structure does not exclude another one that explains as much.
#include "beam_generator/random_case.hpp"
#include "diagnosis_records.hpp"

#include <algorithm>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace culm::tests {
namespace {

/// A curved stem with internal friction at twenty times the noise; the friction is not among the
/// candidates. The curvature and a relaxation both bend the stem at rest and explain 98 %.
TEST(Refusal, FollowsWhereTwoEffectsExplainAsMuchAndLeaveStructure) {
    const beam::RandomCase hidden = beam::random_case(9, beam::CaseKind::Pair, 13);
    ASSERT_EQ(hidden.spec.effects.front().name, "precurvature");
    const std::vector<measure::Measurement> recordings{beam::record(hidden.spec)};
    diagnose::DiagnosisOptions options = quick_diagnosis("relaxation,precurvature,camera_tilt");
    options.most_effects = 1;
    const diagnose::Diagnosis found = diagnose::diagnose(recordings, options);
    EXPECT_TRUE(found.conclusion == diagnose::Conclusion::Tie ||
                found.conclusion == diagnose::Conclusion::Unknown)
        << found.reason;
    EXPECT_TRUE(found.families.empty()); // a curvature and a loss have nothing in common
}

/// Drag and a slight taper; the taper is not among the candidates.
diagnose::Diagnosis with_taper(double relative_change) {
    beam::RecordingSpec spec;
    spec.id = "drag";
    spec.heights = beam::even_heights(spec.stem.length, 8);
    spec.duration = 0.35;
    spec.errors.noise = 0.02e-3;
    spec.effects = {{"quadratic_drag", {{"drag_coefficient", 1.5}}},
                    {"taper", {{"relative_change", relative_change}}}};
    const std::vector<measure::Measurement> recordings{beam::record(spec)};
    diagnose::DiagnosisOptions options = quick_diagnosis("quadratic_drag");
    return diagnose::diagnose(recordings, options);
}

// The misfit is a few times the noise, and its share is known to a fraction of a percent.
TEST(Answer, IsGivenWithTheUnexplainedShareDespiteALittleStructure) {
    const diagnose::Diagnosis found = with_taper(0.15);
    EXPECT_EQ(found.conclusion, diagnose::Conclusion::Effect) << found.reason;
    EXPECT_LT(found.baseline.reduced_chi_squared, 25.0);
    EXPECT_EQ(found.ladder.back().finding, diagnose::Finding::Inadequate);
    EXPECT_GT(found.unexplained, 0.0);
    const diagnose::Diagnosis half = with_taper(0.3);
    EXPECT_EQ(half.conclusion, diagnose::Conclusion::Unknown) << half.reason;
}

} // namespace
} // namespace culm::tests
