// SPDX-License-Identifier: BSD-3-Clause
// Flawed recordings: the diagnosis may say less about them, but nothing wrong.
#include "beam_generator/recording.hpp"
#include "diagnosis_records.hpp"

#include <functional>
#include <ostream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace culm::tests {
namespace {

using diagnose::Conclusion;

struct Flaw {
    std::string name;
    std::function<void(beam::RecordingSpec&)> apply;
};

[[maybe_unused]] void PrintTo(const Flaw& flaw, std::ostream* out) { // NOLINT: GoogleTest's name
    *out << flaw.name;
}

std::vector<Flaw> flaws() {
    return {
        {"none", [](beam::RecordingSpec&) {}},
        {"unknown_noise", [](auto& spec) { spec.errors.is_noise_stated = false; }},
        {"rounded", [](auto& spec) { spec.errors.quantum = 0.1e-3; }},
        {"outliers",
         [](auto& spec) {
             spec.errors.outlier_share = 0.005;
             spec.errors.outlier_size = 0.5e-3;
         }},
        {"gaps", [](auto& spec) { spec.errors.missing_share = 0.2; }},
        {"correlated_noise", [](auto& spec) { spec.errors.correlation = 0.5; }},
        {"wrong_length", [](auto& spec) { spec.errors.length_error = 0.01; }},
        {"late_release", [](auto& spec) { spec.errors.clock_error = 0.6e-3; }},
        {"short", [](auto& spec) { spec.duration = 0.08; }},
    };
}

class FlawedRecording : public testing::TestWithParam<Flaw> {
  protected:
    [[nodiscard]] static diagnose::Diagnosis diagnosed(std::vector<beam::HiddenEffect> effects) {
        beam::RecordingSpec spec;
        spec.effects = std::move(effects);
        spec.heights = beam::even_heights(spec.stem.length, 6);
        spec.duration = 0.12;
        spec.errors.noise = 0.05e-3;
        GetParam().apply(spec);
        const std::vector<measure::Measurement> recordings{beam::record(spec)};
        diagnose::DiagnosisOptions options = quick_diagnosis(
            "taper,bending_nonlinearity,relaxation,clamp_compliance,quadratic_drag,camera_tilt");
        options.candidate.chain.spheres = 28;
        options.null_draws = 0;
        return diagnose::diagnose(recordings, options);
    }
};

TEST_P(FlawedRecording, OfNothingMissingNamesNothing) {
    const diagnose::Diagnosis found = diagnosed({});
    EXPECT_NE(found.conclusion, Conclusion::Effect)
        << ::testing::PrintToString(found.effects) << ": " << found.reason;
}

TEST_P(FlawedRecording, OfDragNamesNothingElse) {
    const diagnose::Diagnosis found = diagnosed({{"quadratic_drag", {{"drag_coefficient", 1.2}}}});
    if (found.conclusion != Conclusion::Effect)
        return; // less is allowed
    EXPECT_EQ(found.effects, std::vector<std::string>{"quadratic_drag"}) << found.reason;
}

INSTANTIATE_TEST_SUITE_P(All, FlawedRecording, testing::ValuesIn(flaws()),
                         [](const auto& flaw) { return flaw.param.name; });

} // namespace
} // namespace culm::tests
