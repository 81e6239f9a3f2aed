// SPDX-License-Identifier: BSD-3-Clause
// Time-step studies, from the study file to the summary.
#include "core/error.hpp"
#include "present/study/study.hpp"
#include "refused.hpp"
#include "small_studies.hpp"
#include "study/execute/execute.hpp"
#include "study/summary/summary.hpp"
#include "support/temporary_folder.hpp"

#include <cmath>
#include <filesystem>
#include <limits>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace culm::study {
namespace {

using present::summary_json;
using present::write_summary;

const std::string header = "[study]\nkind = \"timestep\"\n";

TEST(TimestepConfig, HasDefaultsForEverything) {
    const StudyConfig config = parse_config(header, "s.toml");
    EXPECT_EQ(config.kind, StudyKind::Timestep);
    EXPECT_EQ(config.base.store, run::StoreLevel::Fit);
    EXPECT_EQ(config.timestep.limit_tolerance, 0.01);
    EXPECT_EQ(config.timestep.trial_steps, 20'000);
    EXPECT_TRUE(config.timestep.fractions.empty());
    EXPECT_EQ(parse_config(header + "[timestep]\nlimit_tolerance = 1e-4\n", "s.toml")
                  .timestep.trial_steps,
              200'000);
}

TEST(TimestepConfig, SortsTheFractions) {
    const StudyConfig config =
        parse_config(header + "[timestep]\nfractions = [0.9, 0.1, 0.5]\n", "s.toml");
    EXPECT_EQ(config.timestep.fractions, (std::vector<double>{0.1, 0.5, 0.9}));
}

TEST(TimestepConfig, RefusesKeysOfTheOtherKind) {
    EXPECT_EQ(refusal(header + "[vibration]\nduration_s = 0.2\n[reduce]\nwindow_s = 0.01\n"),
              "s.toml:4: vibration.duration_s = 0.2: only with study.kind = \"vibration\"\n"
              "s.toml:6: reduce.window_s = 0.01: only with study.kind = \"vibration\"");
    EXPECT_EQ(refusal("[study]\nkind = \"timestep\"\nstore = \"tip\"\n"),
              "s.toml:3: study.store = \"tip\": study.kind = \"timestep\" keeps no histories: "
              "\"fit\" or nothing");
    EXPECT_EQ(refusal("[timestep]\nfractions = [0.5]\n"),
              "s.toml:2: timestep.fractions = [0.5]: only with study.kind = \"timestep\"");
    EXPECT_EQ(refusal(header + "[timestep]\nrecord_cycles = 3\n"),
              "s.toml:4: timestep.record_cycles = 3: only with timestep.fractions");
}

TEST(TimestepConfig, RefusesInvalidFractions) {
    const std::string start = header + "[timestep]\n";
    for (const char* fractions : {"[0.5, 1]", "[0]", "[]", "[1.5]", "0.5", "[0.5, 0.5]"})
        EXPECT_NE(refusal(start + "fractions = " + fractions), "accepted") << fractions;
    EXPECT_NE(refusal(start + "limit_tolerance = 0.01\ntrial_steps = 1999\n")
                  .find("must be at least 20/limit_tolerance = 2000"),
              std::string::npos);
    EXPECT_NE(refusal("[study]\nkind = \"timesteps\"\n").find("did you mean \"timestep\"?"),
              std::string::npos);
}

TEST(TimestepConfig, IdentityContainsWhatInfluencesTheResults) {
    const auto identity = [](const std::string& text) {
        return parse_config(header + text, "s.toml").identity();
    };
    EXPECT_NE(identity(""), parse_config("", "s.toml").identity());
    EXPECT_EQ(identity(""), identity("[timestep]\nlimit_tolerance = 0.01\n"));
    EXPECT_NE(identity(""), identity("[timestep]\nlimit_tolerance = 0.02\n"));
    EXPECT_NE(identity("[timestep]\nfractions = [0.5]\n"),
              identity("[timestep]\nfractions = [0.5]\nrecord_cycles = 3\n"));
}

TEST(Richardson, ExtrapolatesParabolasAndLinesToZero) {
    const auto parabola = [](double h) { return 3.0 + 2.0 * h - 5.0 * h * h; };
    const std::vector<double> steps{0.4, 0.1, 0.3, 0.2};
    std::vector<double> values;
    for (const double h : steps)
        values.push_back(parabola(h));
    values[0] = 77.0; // the largest of four steps is not used
    EXPECT_NEAR(extrapolated_to_zero(steps, values), 3.0, 1e-14);
    EXPECT_NEAR(extrapolated_to_zero({0.1, 0.2}, {3.2, 3.4}), 3.0, 1e-14);
    const double nothing = std::numeric_limits<double>::quiet_NaN();
    EXPECT_NEAR(extrapolated_to_zero({0.05, 0.1, 0.2}, {nothing, 3.2, 3.4}), 3.0, 1e-14);
    EXPECT_TRUE(std::isnan(extrapolated_to_zero({0.1}, {3.2})));
}

class TimestepStudy : public testing::Test {
  protected:
    TimestepSummary run_study(const std::string& text) {
        const Study study = parse_study(text, "s.toml");
        EXPECT_TRUE(execute(study, folder_, nullptr, {}).archive_is_complete);
        return reduce_timestep_study(open_archive(folder_));
    }
    tests::TemporaryFolder place_;
    StudyFolder folder_{place_ / "out"};
};

TEST_F(TimestepStudy, FindsLimitsLawsAndErrors) {
    const TimestepSummary found = run_study(small::timestep_study);
    ASSERT_EQ(found.stems.size(), 4U);
    EXPECT_TRUE(found.failed.empty());
    for (const TimestepStem& stem : found.stems) {
        // The bracket is 1 % wide, and the released stem is slightly bent.
        EXPECT_NEAR(stem.limit() / stem.linearised(), 1.0, 0.011);
        EXPECT_LT(stem.rule, stem.stable); // law schramm2019
        ASSERT_EQ(stem.steps.size(), 3U);
        for (std::size_t k = 0; k < 3; ++k) {
            const StepResult& step = stem.steps[k];
            EXPECT_EQ(step.outcome, StepOutcome::Fitted);
            // Fewest steps per sample that do not exceed the share.
            EXPECT_LE(step.step, found.options.fractions[k] * stem.linearised() * (1 + 1e-12));
            EXPECT_GT(step.step, 0.9 * found.options.fractions[k] * stem.linearised());
            EXPECT_LT(std::abs(step.frequency_error), 1e-3);
            EXPECT_LT(std::abs(step.decay_error), 1e-3);
        }
        EXPECT_GT(std::abs(stem.steps[2].frequency_error),
                  2.0 * std::abs(stem.steps[0].frequency_error));
        // The limit of zero step agrees with the implicit method, which shares only the force law,
        // within the tolerance 1e-9 over some hundred steps.
        EXPECT_NEAR(stem.reference_frequency / stem.converged_frequency, 1.0, 1e-6);
        EXPECT_NEAR(stem.reference_decay / stem.converged_decay, 1.0, 1e-5);
    }
    ASSERT_TRUE(found.regression.damped_oscillator.law);
    EXPECT_LT(found.regression.damped_oscillator.law->largest_residual, 0.03);
}

TEST_F(TimestepStudy, ErrorsDoNotDependOnYoungsModulus) {
    const TimestepSummary found = run_study(small::timestep_study);
    // Points 0 and 1 (2 and 3) differ in Y alone: the same motion in another unit of time.
    for (const std::size_t first : {0U, 2U})
        for (std::size_t k = 0; k < 3; ++k) {
            const StepResult& soft = found.stems[first].steps[k];
            const StepResult& stiff = found.stems[first + 1].steps[k];
            // Rounding of the extrapolated value, 1e-12, relative to errors of 1e-6 and more.
            EXPECT_NEAR(soft.frequency_error / stiff.frequency_error, 1.0, 1e-3);
            EXPECT_NEAR(soft.decay_per_cycle / stiff.decay_per_cycle, 1.0, 1e-8);
        }
}

TEST_F(TimestepStudy, FindsOnlyTheLimitsWithoutFractions) {
    std::string text = small::timestep_study;
    text.erase(text.find("fractions"));
    const TimestepSummary found = run_study(text);
    ASSERT_EQ(found.stems.size(), 4U);
    EXPECT_TRUE(found.stems[0].steps.empty());
    EXPECT_GT(found.stems[0].stable, 0.0);
    const nlohmann::json json = summary_json(found);
    EXPECT_TRUE(json["errors"].empty());
    EXPECT_FALSE(json.contains("implicit_against_converged"));
}

TEST_F(TimestepStudy, StemThatDoesNotSwingKeepsItsLimitAndSaysThatThereIsNoFit) {
    const TimestepSummary found =
        run_study(header + "[stem]\nspheres = 4\nbond_damping = 500\n[release]\n"
                           "tip_deflection_mm = 0.1\n[timestep]\nfractions = [0.5]\n");
    ASSERT_EQ(found.stems.size(), 1U);
    EXPECT_GT(found.stems[0].stable, 0.0);
    EXPECT_EQ(found.stems[0].steps[0].outcome, StepOutcome::NoFit);
    EXPECT_TRUE(std::isnan(found.stems[0].steps[0].frequency));
    EXPECT_TRUE(summary_json(found)["errors"][0]["frequency_error"].is_null());
}

TEST_F(TimestepStudy, WritesItsSummary) {
    const TimestepSummary found = run_study(small::timestep_study);
    write_summary(folder_, found);
    EXPECT_TRUE(std::filesystem::exists(folder_.path() / "summary.json"));
    const nlohmann::json json = summary_json(found);
    EXPECT_EQ(json["kind"], "timestep");
    EXPECT_EQ(json["completed"], 4);
    EXPECT_EQ(json["limits"]["axial"], 4);
    EXPECT_EQ(json["errors"].size(), 3U);
    EXPECT_EQ(json["errors"][1]["fitted"], 4);
    EXPECT_EQ(json["regression"]["damped_oscillator"]["coefficients"][0]["term"], "A");
}

TEST_F(TimestepStudy, CannotBeReducedAsAVibrationStudy) {
    (void)run_study(small::timestep_study);
    EXPECT_THROW((void)reduce_study(open_archive(folder_), std::nullopt), core::InputError);
    const StudyFolder other(place_ / "vibration");
    EXPECT_TRUE(execute(parse_study(small::explicit_study, "s.toml"), other, nullptr, {})
                    .archive_is_complete);
    EXPECT_THROW((void)reduce_timestep_study(open_archive(other)), core::InputError);
}

} // namespace
} // namespace culm::study
