// SPDX-License-Identifier: BSD-3-Clause
#include "calibrate/calibration.hpp"
#include "core/error.hpp"
#include "fit/chain/baseline_model.hpp"
#include "fit/fit.hpp"
#include "fit/fit_model.hpp"
#include "reduce/ring_down/ring_down_fit.hpp"
#include "support/parameter_ids.hpp"
#include "support/simulated_measurement.hpp"
#include "support/single_fit.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace {

using namespace culm;

fit::RecordingFit fitted(const measure::Measurement& measurement,
                         const fit::FitOptions& options = {}) {
    return tests::fit_chain(fit::baseline_model(measurement), measurement, options);
}

double deviation(const fit::RecordingFit& fit, const physics::ParameterId& id, double truth) {
    const fit::FittedParameter* found = fit.find(id);
    return (found->value - truth) / found->standard_error;
}

TEST(RecordingFit, FindsTheValuesThatMadeTheRecordWithinTheirErrors) {
    const tests::TrueValues truth;
    const fit::RecordingFit fit = fitted(tests::simulated_measurement(truth));
    // Four standard errors: one false alarm in 4000 for the four together.
    EXPECT_LT(std::abs(deviation(fit, physics::bond_youngs_modulus, truth.bond_youngs_modulus)),
              4.0);
    EXPECT_LT(std::abs(deviation(fit, physics::bond_damping, truth.bond_damping)), 4.0);
    EXPECT_LT(std::abs(deviation(fit, physics::tip_deflection, truth.tip_deflection)), 4.0);
    EXPECT_LT(std::abs(deviation(fit, physics::release_time, truth.release_time)), 4.0);
    // 616 degrees of freedom: a standard error of 5.7 %.
    EXPECT_NEAR(fit.reduced_chi_squared, 1.0, 0.23);
    EXPECT_EQ(fit.readings, 155U * 4U);
    EXPECT_EQ(fit.degrees_of_freedom, fit.readings - 4);
}

TEST(RecordingFit, HasStandardErrorsThatMatchTheScatterOverManyRecords) {
    const tests::TrueValues truth;
    double sum = 0.0;
    constexpr int records = 16;
    for (unsigned seed = 1; seed <= records; ++seed) {
        const fit::RecordingFit fit = fitted(tests::simulated_measurement(truth, seed));
        const double scaled =
            deviation(fit, physics::bond_youngs_modulus, truth.bond_youngs_modulus);
        sum += scaled * scaled;
    }
    // χ² with 16 degrees of freedom lies in 4.5 … 36 with a probability of 99.5 %.
    EXPECT_GT(sum, 4.5);
    EXPECT_LT(sum, 36.0);
}

TEST(BaselineModel, StartsFromAStemThatIsCurvedAtRest) {
    measure::Measurement measurement = tests::simulated_measurement();
    for (std::size_t place = 0; place < measurement.deflections.size(); ++place) {
        const double height = measurement.heights[place % measurement.heights.size()];
        measurement.deflections[place] += 0.5 * 20.0 * height * height; // m, curvature 20/m
    }
    reduce::RingDownOptions about_zero{.is_measured = true};
    about_zero.has_phase = true;
    for (std::size_t j = 2; j < measurement.heights.size(); ++j)
        EXPECT_THROW(static_cast<void>(reduce::fit_ring_down(measurement.times,
                                                             measurement.history(j), about_zero)),
                     core::NumericalError);
    const fit::StemModel start = fit::baseline_model(measurement);
    EXPECT_NEAR(start.spec.stem.bond_youngs_modulus, 1.3e9, 0.05 * 1.3e9);
}

TEST(RecordingFit, HasAJacobianThatMatchesDifferencesOfPredictions) {
    const measure::Measurement measurement = tests::empty_measurement();
    fit::StemModel model = tests::true_model(measurement, {});
    const auto base = fit::predict_readings(model, measurement.times);
    const double change = 1e-4;
    model.spec.stem.bond_youngs_modulus *= 1.0 + change;
    const auto above = fit::predict_readings(model, measurement.times);
    model.spec.stem.bond_youngs_modulus *= (1.0 - change) / (1.0 + change);
    const auto below = fit::predict_readings(model, measurement.times);
    double largest = 0.0;
    double error = 0.0;
    for (std::size_t k = 0; k < base.readings.size(); ++k) {
        const double by_difference = (above.readings[k] - below.readings[k]) / (2.0 * change);
        const double by_jacobian = base.jacobian[4 * k]; // by ln Y
        largest = std::max(largest, std::abs(by_jacobian));
        error = std::max(error, std::abs(by_difference - by_jacobian));
    }
    // The steps of the runs differ: 1e-6 of the deflection over twice the change is 0.5 %.
    EXPECT_LT(error, 0.02 * largest);
}

// More models than a processor has lanes, and an odd number.
TEST(ChainPrediction, DoesNotDependOnTheOtherModelsOfTheBatch) {
    const measure::Measurement measurement = tests::empty_measurement();
    std::vector<fit::StemModel> models(19, tests::true_model(measurement, {}));
    for (std::size_t k = 0; k < models.size(); ++k)
        models[k].spec.stem.bond_youngs_modulus *= 1.0 + 1e-4 * static_cast<double>(k);
    const auto together = fit::predict_together(models, measurement.times);
    ASSERT_EQ(together.size(), models.size());
    for (std::size_t k = 1; k < models.size(); ++k) {
        const std::vector<fit::StemModel> pair{models.front(), models[k]};
        EXPECT_EQ(fit::predict_together(pair, measurement.times)[1].readings, together[k].readings)
            << k;
    }
}

TEST(RecordingFit, HasTheDerivativeByTheReleaseTimeOfADifference) {
    const measure::Measurement measurement = tests::empty_measurement();
    fit::StemModel model = tests::true_model(measurement, {});
    const auto base = fit::predict_readings(model, measurement.times);
    model.release_time += 1e-6;
    const auto later = fit::predict_readings(model, measurement.times);
    for (std::size_t k = 0; k < base.readings.size(); ++k) {
        // 10 m/s² … 1e4 m/s² of acceleration over half the shift: 5e-3 m/s.
        const double difference = (later.readings[k] - base.readings[k]) / 1e-6;
        EXPECT_NEAR(base.jacobian[4 * k + 3], difference, 5e-3);
    }
}

TEST(RecordingFit, HasTheStaticShapeBeforeTheRelease) {
    const measure::Measurement measurement = tests::empty_measurement();
    const auto prediction =
        fit::predict_readings(tests::true_model(measurement, {}), measurement.times);
    for (std::size_t j = 0; j < 4; ++j)
        EXPECT_EQ(prediction.readings[j], prediction.readings[4 * 4 + j]); // frames 0 and 4
}

TEST(RecordingFit, OmitsGaps) {
    measure::Measurement measurement = tests::simulated_measurement();
    for (std::size_t k = 0; k < measurement.deflections.size(); k += 3)
        measurement.deflections[k] = std::nan("");
    const fit::RecordingFit fit = fitted(measurement);
    EXPECT_EQ(fit.readings, 155U * 4U - 207U);
    EXPECT_TRUE(std::isnan(fit.residuals[0]));
    EXPECT_LT(std::abs(deviation(fit, physics::bond_youngs_modulus, 1.3e9)), 4.0); // as above
}

TEST(RecordingFit, GivesWrongReadingsLittleWeight) {
    measure::Measurement measurement = tests::simulated_measurement();
    for (std::size_t k = 7; k < measurement.deflections.size(); k += 40)
        measurement.deflections[k] += 5e-3;
    const auto error = [](const fit::RecordingFit& fit) {
        return std::abs(fit.find(tests::id("tip_deflection"))->value - 15e-3);
    };
    const double weighted_error = error(fit::fit_baseline({&measurement, 1}).fit.parts.front());
    EXPECT_LT(weighted_error, 0.5 * error(fitted(measurement)));
    EXPECT_LT(weighted_error, 30e-6); // 16 of 620 readings wrong by 100 σ
}

TEST(RecordingFit, RecoversFromAModulusThatIsATenthTooLarge) {
    const measure::Measurement measurement = tests::simulated_measurement();
    fit::StemModel model = fit::baseline_model(measurement);
    model.spec.stem.bond_youngs_modulus *= 1.1; // half a cycle off at the end of the record
    const fit::RecordingFit fit = tests::fit_chain(model, measurement);
    EXPECT_LT(std::abs(deviation(fit, physics::bond_youngs_modulus, 1.3e9)), 4.0);
}

TEST(RecordingFit, ReportsWhichParameterEndsAtItsBound) {
    const measure::Measurement measurement = tests::simulated_measurement();
    fit::StemModel model = fit::baseline_model(measurement);
    model.parameters[1].upper = 5.0; // β is 12
    model.spec.stem.bond_damping = 4.0;
    const fit::Fit fit = tests::fit_exactly(model, measurement);
    EXPECT_TRUE(fit.parts.front().find(tests::id("bond_damping"))->is_at_bound);
    EXPECT_NE(fit.reason.find("bond_damping is at its bound"), std::string::npos) << fit.reason;
}

TEST(RecordingFit, EstimatesUnknownNoiseFromTheResiduals) {
    measure::Measurement measurement = tests::simulated_measurement();
    measurement.noise.reset();
    measurement.times.erase(measurement.times.begin(), measurement.times.begin() + 5);
    measurement.deflections.erase(measurement.deflections.begin(),
                                  measurement.deflections.begin() + 20);
    const fit::RecordingFit fit = fitted(measurement);
    EXPECT_FALSE(fit.is_noise_known);
    EXPECT_DOUBLE_EQ(fit.reduced_chi_squared, 1.0);
    EXPECT_NEAR(fit.noise.front(), 0.05e-3, 0.006e-3); // 600 readings: 2.9 % standard error
}

} // namespace
