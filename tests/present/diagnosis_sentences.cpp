// SPDX-License-Identifier: BSD-3-Clause
// Sentences about a diagnosis that its user must not miss.
#include "beam_generator/recording.hpp"
#include "physics/effects/selection.hpp"
#include "present/diagnosis.hpp"

#include <string>
#include <vector>

#include <gmock/gmock.h>

namespace culm::tests {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

/// A diagnosis of a stem without an effect, by few spheres.
struct Example {
    std::vector<measure::Measurement> recordings;
    diagnose::DiagnosisOptions options;
    diagnose::Diagnosis found;

    Example() {
        beam::RecordingSpec spec;
        spec.heights = beam::even_heights(spec.stem.length, 4);
        spec.duration = 0.1;
        spec.errors.noise = 0.1e-3;
        recordings = {beam::record(spec)};
        options.candidate.chain.spheres = 12;
        options.candidates = physics::parse_effects("tip_mass", {});
        found = diagnose::diagnose(diagnose::specimens_of(recordings), options);
        found.next_experiments.clear();
    }
    [[nodiscard]] std::string text() const {
        return present::diagnosis_text({found, recordings, options}, false);
    }
};

TEST(DiagnosisText, SaysThatTheSearchEndedEarly) {
    Example example;
    EXPECT_THAT(example.text(), Not(HasSubstr("The search ended")));
    example.found.is_complete = false;
    EXPECT_THAT(example.text(), HasSubstr("The search ended after"));
}

// Errors of the models count from ten standard deviations on.
TEST(DiagnosisText, PromisesAtMostTenSigma) {
    Example example;
    diagnose::Experiment experiment{"release again", {"baseline"}, {"baseline", "tip_mass"}, 49.0};
    example.found.next_experiments = {experiment};
    EXPECT_THAT(example.text(), HasSubstr("with 7 sigma"));
    experiment.expected_gap = 1e6;
    example.found.next_experiments = {experiment};
    EXPECT_THAT(example.text(), HasSubstr("more than 10"));
}

} // namespace
} // namespace culm::tests
