// SPDX-License-Identifier: BSD-3-Clause
// Flawed recordings: the verdict of each, with hidden drag and without.
#include "beam_generator/flaw.hpp"
#include "beam_generator/recording.hpp"
#include "diagnosis_records.hpp"

#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace culm::tests {
namespace {

using diagnose::Conclusion;

std::vector<std::string> names_of_flaws() {
    std::vector<std::string> names;
    for (const beam::Flaw& flaw : beam::flaws())
        names.push_back(flaw.name);
    return names;
}

class FlawedRecording : public testing::TestWithParam<std::string> {
  protected:
    [[nodiscard]] static diagnose::Diagnosis diagnosed(std::vector<beam::HiddenEffect> effects) {
        beam::RecordingSpec spec;
        spec.effects = std::move(effects);
        spec.heights = beam::even_heights(spec.stem.length, 6);
        spec.duration = 0.12;
        spec.errors.noise = 0.05e-3;
        beam::flaw_named(GetParam()).apply(spec);
        const std::vector<measure::Measurement> recordings{beam::record(spec)};
        diagnose::DiagnosisOptions options = quick_diagnosis(
            "taper,bending_nonlinearity,relaxation,clamp_compliance,quadratic_drag,camera_tilt");
        return diagnose::diagnose(diagnose::specimens_of(recordings), options);
    }
};

TEST_P(FlawedRecording, IsAdequateWhereNothingIsMissing) {
    const diagnose::Diagnosis found = diagnosed({});
    EXPECT_EQ(found.conclusion, Conclusion::Adequate)
        << ::testing::PrintToString(found.effects) << ": " << found.reason;
}

// The laws of noise of a fit do not describe readings that are rounded to two standard deviations
// or have far outliers: what drag leaves there is not noise.
TEST_P(FlawedRecording, HasDragOrIsUnknown) {
    const diagnose::Diagnosis found = diagnosed({{"quadratic_drag", {{"drag_coefficient", 1.2}}}});
    const bool is_beyond_the_laws = GetParam() == "rounded" || GetParam() == "outliers";
    EXPECT_EQ(found.conclusion, is_beyond_the_laws ? Conclusion::Unknown : Conclusion::Effect)
        << found.reason;
    if (!is_beyond_the_laws) {
        EXPECT_EQ(found.effects, std::vector<std::string>{"quadratic_drag"}) << found.reason;
    }
}

INSTANTIATE_TEST_SUITE_P(All, FlawedRecording, testing::ValuesIn(names_of_flaws()),
                         [](const auto& flaw) { return flaw.param; });

} // namespace
} // namespace culm::tests
