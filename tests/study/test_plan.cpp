// SPDX-License-Identifier: BSD-3-Clause
// Properties of a study before it runs: stability, batches, costs.
#include "core/error.hpp"
#include "run/simulate.hpp"
#include "small_studies.hpp"
#include "study/execute/plan.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include <fmt/core.h>
#include <gtest/gtest.h>

namespace culm::study {
namespace {

run::CaseSpec first_case(const std::string& text) {
    const Study study = small::unchecked(text);
    return case_of_point(study.config, study.design, 0);
}

std::string explicit_in_steps_of(const std::string& timestep) {
    return "[stem]\nspheres = 8\n[integrator]\nmethod = \"explicit\"\ntimestep_s = " + timestep +
           "\n[vibration]\nduration_s = 1e-3\nsample_interval_s = 1e-5\n";
}

std::string refusal_of_study(const std::string& text) {
    try {
        (void)parse_study(text, "s.toml");
    } catch (const core::InputError& error) {
        return error.what();
    }
    return "accepted";
}

TEST(Plan, StepAboveTheLimitIsRefusedWithTheLimitAndThePoints) {
    const std::string text =
        explicit_in_steps_of("1e-8") + "[factors]\nbond_damping = [1, 100, 200]\n";
    const Study study = small::unchecked(text);
    const auto limit_of = [&study](std::int64_t point) {
        return run::largest_stable_timestep(case_of_point(study.config, study.design, point));
    };
    ASSERT_GT(limit_of(0), 1e-8);
    ASSERT_LT(limit_of(1), 1e-8);
    const std::string refusal = refusal_of_study(text);
    EXPECT_EQ(
        refusal.find("s.toml: 2 of 3 points are impossible:\n  point 1: integrator.timestep_s "
                     "= 1e-08 is above the largest stable step of the linearised chain, "),
        0U)
        << refusal;
    EXPECT_NE(refusal.find(" s (bond_damping = 100)\n  point 2: "), std::string::npos) << refusal;
    // The limit itself, to three digits and never above it.
    for (const std::int64_t point : {1, 2}) {
        const auto where =
            refusal.find(" linearised chain, ", refusal.find(fmt::format("point {}: ", point)));
        const double said = std::stod(refusal.substr(where + 19));
        EXPECT_LE(said, limit_of(point));
        EXPECT_GT(said, 0.99 * limit_of(point));
    }
}

TEST(Plan, StepThatAMessageCalledTheLimitIsAccepted) {
    const std::string refusal =
        refusal_of_study(explicit_in_steps_of("1e-8") + "[factors]\nbond_damping = [100]\n");
    const auto where = refusal.find(" linearised chain, ");
    ASSERT_NE(where, std::string::npos) << refusal;
    const std::string said =
        refusal.substr(where + 19, refusal.find(" s", where + 19) - where - 19);
    // A sample interval of 1000 steps, which any step divides.
    EXPECT_EQ(refusal_of_study(
                  "[stem]\nspheres = 8\n[integrator]\nmethod = \"explicit\"\n"
                  "timestep_s = " +
                  said +
                  "\n[vibration]\nduration_s = " + fmt::format("{:.17g}", 1e5 * std::stod(said)) +
                  "\nsample_interval_s = " + fmt::format("{:.17g}", 1e3 * std::stod(said)) +
                  "\n[factors]\nbond_damping = [100]\n"),
              "accepted");
}

TEST(Plan, RefusalEndsWithTheStepThatSuitsEveryPoint) {
    const std::string text =
        explicit_in_steps_of("1e-8") + "[factors]\nbond_damping = [100, 200, 1]\n";
    const Study study = small::unchecked(text);
    const double limit = run::largest_stable_timestep(case_of_point(study.config, study.design, 1));
    const std::string refusal = refusal_of_study(text);
    const std::string words = "\n  every point is stable with integrator.timestep_s = ";
    const auto where = refusal.find(words);
    ASSERT_NE(where, std::string::npos) << refusal;
    const double said = std::stod(refusal.substr(where + words.size()));
    EXPECT_LE(said, limit);
    EXPECT_GT(said, 0.99 * limit);
}

TEST(Plan, LimitHoldsAtEveryYoungsModulusOfTheDesign) {
    // The limit falls as 1/√Y: a step that 1 GPa allows is too long for 100 GPa.
    const std::string text =
        explicit_in_steps_of("2e-9") + "[factors]\nbond_youngs_modulus_gpa = [1, 100]\n";
    const Study study = small::unchecked(text);
    ASSERT_GT(run::largest_stable_timestep(case_of_point(study.config, study.design, 0)), 2e-9);
    const std::string refusal = refusal_of_study(text);
    EXPECT_NE(refusal.find("1 of 2 points are impossible:\n  point 1: "), std::string::npos)
        << refusal;
}

TEST(Plan, ImplicitStudiesHaveNoLargestStep) {
    EXPECT_EQ(refusal_of_study("[factors]\nbond_damping = [1, 100000]\n"), "accepted");
}

TEST(Batches, ExplicitPointsFillTheLanesAndTheLastBatchTakesTheRest) {
    const Study study = parse_study(small::explicit_study, "s.toml");
    const auto batches = make_batches(study, small::all_points(study));
    const std::size_t lanes = run::lanes_per_batch();
    ASSERT_EQ(batches.size(), (11 + lanes - 1) / lanes);
    std::vector<std::int64_t> in_batches;
    for (std::size_t k = 0; k < batches.size(); ++k) {
        if (k + 1 < batches.size()) {
            EXPECT_EQ(batches[k].points.size(), lanes);
        }
        in_batches.insert(in_batches.end(), batches[k].points.begin(), batches[k].points.end());
    }
    EXPECT_EQ(in_batches, small::all_points(study));
}

TEST(Batches, HoldOnlyPointsWhoseLanesCanRunTogether) {
    // Chains with different numbers of spheres cannot share lanes: 2, 1 and 2 points in a row.
    const Study study = parse_study(R"(
[integrator]
method = "explicit"
timestep_s = 1e-9
[vibration]
duration_s = 1e-3
sample_interval_s = 1e-5
[design]
type = "list"
[[design.point]]
spheres = 8
[[design.point]]
spheres = 8
[[design.point]]
spheres = 9
[[design.point]]
spheres = 8
[[design.point]]
spheres = 8
)",
                                    "s.toml");
    std::vector<std::vector<std::int64_t>> points;
    for (const farm::Batch& batch : make_batches(study, small::all_points(study)))
        points.push_back(batch.points);
    EXPECT_EQ(points, (std::vector<std::vector<std::int64_t>>{{0, 1}, {2}, {3, 4}}));
}

TEST(Batches, ImplicitPointsFillTheLanesLongestFirst) {
    const Study study = parse_study(small::implicit_study, "s.toml");
    const auto batches = make_batches(study, small::all_points(study));
    const std::size_t lanes = run::lanes_per_batch();
    ASSERT_EQ(batches.size(), (12 + lanes - 1) / lanes);
    std::vector<std::int64_t> in_batches;
    double last = std::numeric_limits<double>::infinity();
    for (const farm::Batch& batch : batches)
        for (const std::int64_t point : batch.points) {
            const double seconds =
                estimated_seconds(case_of_point(study.config, study.design, point));
            EXPECT_LE(seconds, last) << "point " << point;
            EXPECT_GE(batch.cost, seconds * static_cast<double>(lanes) * (1 - 1e-12));
            last = seconds;
            in_batches.push_back(point);
        }
    std::sort(in_batches.begin(), in_batches.end());
    EXPECT_EQ(in_batches, small::all_points(study));
}

TEST(Batches, HoldTheGivenPointsOnly) {
    const Study study = parse_study(small::implicit_study, "s.toml");
    std::vector<std::int64_t> points;
    for (const farm::Batch& batch : make_batches(study, {3, 7}))
        points.insert(points.end(), batch.points.begin(), batch.points.end());
    std::sort(points.begin(), points.end());
    EXPECT_EQ(points, (std::vector<std::int64_t>{3, 7}));
    EXPECT_TRUE(make_batches(study, {}).empty());
}

TEST(EstimatedSeconds, GrowWithStepsBondsAndDimensionsOfAnExplicitCase) {
    const run::CaseSpec spec = first_case(small::explicit_study);
    const double seconds = estimated_seconds(spec);
    EXPECT_GT(seconds, 0.0);
    run::CaseSpec changed = spec;
    changed.integrator.timestep *= 0.5;
    EXPECT_DOUBLE_EQ(estimated_seconds(changed), 2.0 * seconds);
    changed = spec;
    changed.duration *= 3.0;
    EXPECT_DOUBLE_EQ(estimated_seconds(changed), 3.0 * seconds);
    changed = spec;
    changed.stem.sphere_count = 15; // 14 bonds instead of 7
    EXPECT_DOUBLE_EQ(estimated_seconds(changed), 2.0 * seconds);
    changed = spec;
    changed.dimensions = 3;
    EXPECT_GT(estimated_seconds(changed), 2.0 * seconds);
}

TEST(EstimatedSeconds, GrowWithPeriodsAccuracyAndLightDampingOfAnImplicitCase) {
    const run::CaseSpec spec = first_case(small::implicit_study);
    const double seconds = estimated_seconds(spec);
    EXPECT_GT(seconds, 0.0);
    run::CaseSpec changed = spec;
    changed.duration *= 3.0;
    const double longer = estimated_seconds(changed);
    EXPECT_GT(longer, seconds);
    EXPECT_LT(longer, 3.0 * seconds); // the static start and the first periods do not grow
    run::CaseSpec stiffer = changed;
    stiffer.duration *= 0.5;
    stiffer.stem.bond_youngs_modulus *= 4.0; // twice the frequency: the same number of periods
    EXPECT_DOUBLE_EQ(estimated_seconds(stiffer), longer);
    changed = spec;
    changed.integrator.relative_tolerance *= 1e-5; // a method of order five: ten times the steps
    const double tighter = estimated_seconds(changed) - seconds;
    changed.integrator.relative_tolerance *= 1e-5;
    EXPECT_NEAR((estimated_seconds(changed) - seconds) / tighter, 11.0, 1e-9);
    changed = spec;
    changed.duration = 1.0;
    const double many_periods = estimated_seconds(changed);
    changed.stem.bond_damping = 100.0;
    EXPECT_LT(estimated_seconds(changed), many_periods);
    EXPECT_GT(estimated_seconds(changed), 0.1 * many_periods);
}

TEST(EstimatedSeconds, PredictTheNumberOfImplicitStepsWithinAFactorOfTwo) {
    // The estimate predicts the number of steps; the time per step depends on the machine. A factor
    // of two is sufficient for planning; the measured factors are 0.8 to 1.3.
    const Study study = parse_study("[vibration]\nduration_s = 0.02\n[factors]\n"
                                    "bond_damping = [25, 200]\nbond_youngs_modulus_gpa = [1, 10]\n",
                                    "s.toml");
    const double seconds_per_bond_and_step = 1.3e-6 / static_cast<double>(run::lanes_per_batch());
    for (const std::int64_t point : small::all_points(study)) {
        const run::CaseSpec spec = case_of_point(study.config, study.design, point);
        const auto outcome = run::simulate(spec);
        const auto& result = std::get<run::CaseResult>(outcome);
        run::CaseSpec tighter = spec; // ten times the steps, but the same static start
        tighter.integrator.relative_tolerance *= 1e-5;
        const double steps = (estimated_seconds(tighter) - estimated_seconds(spec)) / 9.0 /
                             (55 * seconds_per_bond_and_step);
        EXPECT_GT(steps, 0.5 * static_cast<double>(result.work.steps)) << "point " << point;
        EXPECT_LT(steps, 2.0 * static_cast<double>(result.work.steps)) << "point " << point;
    }
}

TEST(Estimate, AddsUpTheBatches) {
    const Study study = parse_study(small::explicit_study, "s.toml");
    const auto batches = make_batches(study, small::all_points(study));
    const Estimate total = estimate(study, batches);
    EXPECT_EQ(total.points, 11);
    EXPECT_EQ(total.batches, static_cast<std::int64_t>(batches.size()));
    EXPECT_EQ(total.lanes, std::min<std::size_t>(run::lanes_per_batch(), 11));
    const double sum = std::accumulate(batches.begin(), batches.end(), 0.0,
                                       [](double s, const auto& b) { return s + b.cost; });
    EXPECT_DOUBLE_EQ(total.core_seconds, sum);
    EXPECT_GT(total.core_seconds, 0.0);
}

double archive_bytes_per_point(const std::string& store) {
    const Study study = parse_study("[study]\nstore = " + store +
                                        "\n[stem]\nspheres = 8\n[release]\ntip_deflection_mm = 1\n"
                                        "[vibration]\nduration_s = 1e-2\nsample_interval_s = 1e-5\n"
                                        "[factors]\nbond_damping = [1, 2]\n",
                                    "s.toml");
    return estimate(study, make_batches(study, small::all_points(study))).archive_bytes / 2.0;
}

TEST(Estimate, PredictsTheArchiveSizeFromTheStoredColumns) {
    constexpr double column = 8.0 * 1001.0; // one number of every sample
    const double fit = archive_bytes_per_point("\"fit\"");
    EXPECT_GT(fit, 0.0);
    EXPECT_LT(fit, 1000.0);
    EXPECT_DOUBLE_EQ(archive_bytes_per_point("\"tip\"") - fit, column);
    EXPECT_DOUBLE_EQ(archive_bytes_per_point("\"heights\"\nheights_mm = [5, 10]") - fit,
                     3.0 * column);
    EXPECT_DOUBLE_EQ(archive_bytes_per_point("\"full\"") - fit, (1.0 + 3.0 * 8.0) * column);
}

} // namespace
} // namespace culm::study
