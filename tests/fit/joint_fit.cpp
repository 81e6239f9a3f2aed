// SPDX-License-Identifier: BSD-3-Clause
#include "fit/chain/baseline_model.hpp"
#include "fit/fit.hpp"
#include "physics/effects/selection.hpp"
#include "support/parameter_ids.hpp"
#include "support/simulated_measurement.hpp"
#include "support/single_fit.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <gtest/gtest.h>

namespace {

using namespace culm;

measure::Measurement with_id(measure::Measurement measurement, const std::string& id) {
    measurement.stem.id = id;
    return measurement;
}

/// The same stem pulled 15 mm and 10 mm, released at different times.
std::array<measure::Measurement, 2> two_releases() {
    return {with_id(tests::simulated_measurement(), "a"),
            with_id(tests::simulated_measurement({1.3e9, 12.0, 10e-3, -0.3e-3}, 2), "b")};
}

/// With exact inputs.
fit::Fit fit_together(std::span<const measure::Measurement> measurements,
                      fit::JointOptions options = {}) {
    options.with_inputs = false;
    std::vector<fit::StemModel> models;
    for (const measure::Measurement& measurement : measurements)
        models.push_back(fit::baseline_model(measurement));
    return fit::fit_jointly(models, fit::observed(measurements), options);
}

double value(const fit::Fit& fit, const std::string& name) {
    return std::ranges::find(fit.parameters, tests::id(name), &fit::FittedParameter::id)->value;
}

double error(const fit::Fit& fit, const std::string& name) {
    return std::ranges::find(fit.parameters, tests::id(name), &fit::FittedParameter::id)
        ->standard_error;
}

TEST(Fit, EqualsTheOwnFitOfASingleRecordingBitForBit) {
    const measure::Measurement measurement = tests::simulated_measurement();
    const fit::RecordingFit alone = tests::fit_chain(fit::baseline_model(measurement), measurement);
    const fit::Fit joint = fit_together({&measurement, 1});
    ASSERT_EQ(joint.parameters.size(), alone.parameters.size());
    for (std::size_t k = 0; k < alone.parameters.size(); ++k) {
        EXPECT_EQ(joint.parameters[k].id, alone.parameters[k].id);
        EXPECT_EQ(joint.parameters[k].value, alone.parameters[k].value);
        EXPECT_EQ(joint.parameters[k].standard_error, alone.parameters[k].standard_error);
    }
    EXPECT_EQ(joint.chi_squared, alone.chi_squared);
    EXPECT_EQ(joint.parts.front().residuals, alone.residuals);
}

TEST(Fit, SharesTheMaterialAndNothingOfTheRelease) {
    const auto recordings = two_releases();
    const fit::Fit fit = fit_together(recordings);
    ASSERT_TRUE(fit.failed() == false) << fit.reason;
    std::vector<std::string> names;
    for (const fit::FittedParameter& parameter : fit.parameters)
        names.push_back(to_string(parameter.id));
    EXPECT_EQ(names,
              (std::vector<std::string>{"bond_youngs_modulus", "bond_damping", "tip_deflection@a",
                                        "release_time@a", "tip_deflection@b", "release_time@b"}));
    EXPECT_EQ(fit.readings, 2U * 155U * 4U);
    EXPECT_EQ(fit.degrees_of_freedom, fit.readings - 6);
    // Four standard errors: one false alarm in 3000 for the six together.
    EXPECT_NEAR(value(fit, "bond_youngs_modulus"), 1.3e9, 4.0 * error(fit, "bond_youngs_modulus"));
    EXPECT_NEAR(value(fit, "bond_damping"), 12.0, 4.0 * error(fit, "bond_damping"));
    EXPECT_NEAR(value(fit, "tip_deflection@b"), 10e-3, 4.0 * error(fit, "tip_deflection@b"));
    EXPECT_NEAR(value(fit, "release_time@b"), -0.3e-3, 4.0 * error(fit, "release_time@b"));
    // 1234 degrees of freedom: a standard error of 4 %.
    EXPECT_NEAR(fit.reduced_chi_squared, 1.0, 0.16);
    for (const fit::RecordingFit& part : fit.parts) {
        EXPECT_EQ(part.find(tests::id("bond_youngs_modulus"))->value,
                  value(fit, "bond_youngs_modulus"));
        EXPECT_EQ(part.find(tests::id("bond_youngs_modulus"))->standard_error,
                  error(fit, "bond_youngs_modulus"));
        EXPECT_EQ(part.parameters.size(), 4u);
    }
}

TEST(Fit, AddsTheInformationOfTheRecordings) {
    const auto recordings = two_releases();
    const fit::Fit together = fit_together(recordings);
    double information = 0.0;
    for (const measure::Measurement& measurement : recordings) {
        const fit::Fit alone = fit_together({&measurement, 1});
        information += std::pow(error(alone, "bond_youngs_modulus"), -2.0);
    }
    // The errors scale with the root of the reduced χ², which is 1 ± 5.7 % for one recording.
    EXPECT_NEAR(error(together, "bond_youngs_modulus"), 1.0 / std::sqrt(information),
                0.1 / std::sqrt(information));
}

TEST(Fit, SharesTheDampingTimeAndNotBetaBetweenChainsOfDifferentLength) {
    measure::Measurement other = tests::empty_measurement();
    other.stem.id = "short";
    other.stem.length = 0.12;
    other.heights = {0.04, 0.06, 0.08, 0.11};
    const tests::TrueValues truth;
    fit::StemModel made = tests::true_model(other, truth);
    const double time =
        fit::damping_time(tests::true_model(tests::empty_measurement(), truth).spec);
    made.spec.stem.bond_damping *= time / fit::damping_time(made.spec);
    const double beta = made.spec.stem.bond_damping;
    ASSERT_GT(std::abs(beta / 12.0 - 1.0), 0.2); // otherwise this test could not fail
    const std::array<measure::Measurement, 2> recordings{
        with_id(tests::simulated_measurement(), "long"), tests::read_with_noise(other, made, 3)};
    const fit::Fit fit = fit_together(recordings);
    EXPECT_NEAR(fit.parts[0].find(tests::id("bond_damping"))->value, 12.0,
                4.0 * error(fit, "bond_damping"));
    const fit::FittedParameter* const shorter = fit.parts[1].find(tests::id("bond_damping"));
    EXPECT_NEAR(shorter->value, beta, 4.0 * shorter->standard_error); // as above
    EXPECT_NEAR(fit.reduced_chi_squared, 1.0, 0.16);
}

TEST(Fit, AppliesAKnownMassToItsRecordingOnly) {
    measure::Measurement loaded = tests::empty_measurement();
    loaded.stem.id = "loaded";
    loaded.stem.added_masses.push_back({0.15565, 40e-6}); // half of the stem's mass
    const tests::TrueValues truth;
    const std::array<measure::Measurement, 2> recordings{
        with_id(tests::simulated_measurement(), "bare"),
        tests::read_with_noise(loaded, tests::true_model(loaded, truth), 4)};
    const fit::Fit fit = fit_together(recordings);
    // Without the mass the frequencies differ by a factor of 1.7, and Y by 3.
    EXPECT_NEAR(value(fit, "bond_youngs_modulus"), 1.3e9, 4.0 * error(fit, "bond_youngs_modulus"));
    EXPECT_NEAR(fit.reduced_chi_squared, 1.0, 0.16);
}

TEST(Fit, SeparatesTheReleasesOfRecordingsOfTheSameName) {
    auto recordings = two_releases();
    recordings[1].stem.id = "a";
    const fit::Fit fit = fit_together(recordings);
    EXPECT_NEAR(value(fit, "tip_deflection@a"), 15e-3, 0.1e-3);
    EXPECT_NEAR(value(fit, "tip_deflection@a:2"), 10e-3, 0.1e-3);
}

TEST(Fit, KeepsHeldParametersWithoutError) {
    const auto recordings = two_releases();
    fit::JointOptions options;
    options.is_held = true;
    const double start = fit::baseline_model(recordings[0]).spec.tip_deflection;
    const fit::Fit fit = fit_together(recordings, options);
    // The transformation and its inverse cause a rounding error.
    EXPECT_NEAR(value(fit, "tip_deflection@a"), start, 1e-12);
    EXPECT_EQ(error(fit, "tip_deflection@a"), 0.0);
    EXPECT_EQ(fit.degrees_of_freedom, fit.readings);
}

TEST(Fit, KeepsTheNumbersOfHeldEffectsAndTheirDerivatives) {
    const measure::Measurement measurement = tests::simulated_measurement();
    const fit::StemModel model =
        fit::candidate_model(fit::baseline_model(measurement),
                             physics::parse_effects("quadratic_drag", {}), measurement);
    fit::FitOptions options;
    options.held_effects = {"quadratic_drag"};
    const fit::Fit fit = tests::fit_exactly(model, measurement, options);
    const std::string name = "quadratic_drag.drag_coefficient";
    EXPECT_NEAR(value(fit, name), model.parameters.back().access.get(model.spec), 1e-12);
    EXPECT_EQ(error(fit, name), 0.0);
    const auto column = std::ranges::find(fit.system.ids, tests::id(name));
    ASSERT_NE(column, fit.system.ids.end());
    EXPECT_GT(fit.system.jacobian.col(column - fit.system.ids.begin()).norm(), 1.0);
}

TEST(Fit, EstimatesUnknownNoiseFromTheResidualsOfEachRecording) {
    auto recordings = two_releases();
    for (measure::Measurement& measurement : recordings) {
        measurement.noise.reset();
        measurement.times.erase(measurement.times.begin(), measurement.times.begin() + 5);
        measurement.deflections.erase(measurement.deflections.begin(),
                                      measurement.deflections.begin() + 20);
    }
    const fit::Fit fit = fit_together(recordings);
    for (const fit::RecordingFit& part : fit.parts) {
        EXPECT_DOUBLE_EQ(part.reduced_chi_squared, 1.0);
        EXPECT_NEAR(part.noise.front(), 0.05e-3, 0.006e-3); // 600 readings: 2.9 % standard error
    }
}

} // namespace
