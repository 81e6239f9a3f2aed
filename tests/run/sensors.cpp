// SPDX-License-Identifier: BSD-3-Clause
// Sensors on a simulated chain against beam theory and against each other, and their derivatives.
#include "run/sensitivities.hpp"
#include "run/simulate.hpp"

#include <array>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

namespace culm::run {
namespace {

measure::Sensor sensor_of(measure::Quantity quantity) {
    measure::Sensor sensor;
    sensor.column = "sensor";
    sensor.quantity = quantity;
    sensor.distance_from_axis = quantity == measure::Quantity::Strain ? 1e-3 : 0.0;
    return sensor;
}

/// A stem pulled by 1 % of its length, with a sensor of every quantity near the tip and a strain
/// gauge near the root.
CaseSpec instrumented_stem() {
    CaseSpec spec;
    spec.stem.bond_damping = 20.0;
    spec.stem.tip_mass_share = 0.5;
    spec.tip_deflection = 0.01 * spec.stem.free_length();
    spec.duration = 0.06;
    spec.sample_interval = 1e-4;
    spec.store = StoreLevel::Heights;
    spec.reading = measure::Reading::Material;
    spec.heights = {0.01, 0.12, 0.12, 0.12};
    spec.sensors = {
        sensor_of(measure::Quantity::Strain), sensor_of(measure::Quantity::Displacement),
        sensor_of(measure::Quantity::Velocity), sensor_of(measure::Quantity::Acceleration)};
    return spec;
}

TEST(SensorsOnAChain, ShowTheStrainOfACantileverUnderATipForce) {
    const CaseSpec spec = instrumented_stem();
    const CaseOutcome outcome = simulate(spec);
    const auto& result = std::get<CaseResult>(outcome);
    const double length = spec.stem.free_length();
    const double expected =
        -1e-3 * 3.0 * spec.tip_deflection * (1.0 - 0.01 / length) / (length * length);
    // Shear adds 1e-4 of the deflection; the deflection of 1 % and the cubic through the spheres
    // change the curvature by some 1e-4 as well.
    EXPECT_NEAR(result.height_deflection[0] / expected, 1.0, 2e-3);
}

TEST(SensorsOnAChain, AgreeWithTheDerivativesOfTheDisplacement) {
    const CaseSpec spec = instrumented_stem();
    const CaseOutcome outcome = simulate(spec);
    const auto& table = std::get<CaseResult>(outcome).height_deflection;
    const auto at = [&](std::size_t sample, std::size_t sensor) {
        return table[sample * 4 + sensor];
    };
    const double h = spec.sample_interval;
    double velocity_error = 0.0;
    double acceleration_error = 0.0;
    double velocity = 0.0;
    double acceleration = 0.0;
    // After the first tenth, in which modes beyond the second decay.
    for (std::size_t k = 100; k + 2 < spec.sample_count(); ++k) {
        const double slope =
            (8.0 * (at(k + 1, 1) - at(k - 1, 1)) - (at(k + 2, 1) - at(k - 2, 1))) / (12.0 * h);
        const double bend = (16.0 * (at(k + 1, 1) + at(k - 1, 1)) - (at(k + 2, 1) + at(k - 2, 1)) -
                             30.0 * at(k, 1)) /
                            (12.0 * h * h);
        velocity_error = std::max(velocity_error, std::abs(at(k, 2) - slope));
        acceleration_error = std::max(acceleration_error, std::abs(at(k, 3) - bend));
        velocity = std::max(velocity, std::abs(slope));
        acceleration = std::max(acceleration, std::abs(bend));
    }
    EXPECT_LT(velocity_error, 1e-4 * velocity);
    EXPECT_LT(acceleration_error, 2e-3 * acceleration);
}

TEST(SensorsOnAChain, HaveTheDerivativesOfCentralDifferences) {
    CaseSpec spec = instrumented_stem();
    spec.duration = 0.03;
    const CaseParameter modulus = baseline_parameters().front();
    const SensitivityOutcome outcome = simulate_with_sensitivities(spec, {&modulus, 1});
    const auto& derivatives = std::get<CaseWithSensitivities>(outcome).height_derivatives.front();
    // Runs that are accurate to 1e-10: the difference has an error of 1e-5.
    const double change = 1e-4 * spec.stem.bond_youngs_modulus;
    std::vector<std::vector<double>> beside;
    for (const double side : {1.0, -1.0}) {
        CaseSpec changed = spec;
        changed.integrator.relative_tolerance = 1e-10;
        changed.stem.bond_youngs_modulus += side * change;
        const CaseOutcome run = simulate(changed);
        beside.push_back(std::get<CaseResult>(run).height_deflection);
    }
    // Accelerations are second derivatives of the interpolation between the steps.
    constexpr std::array allowed{1e-3, 1e-3, 1e-3, 5e-3};
    for (std::size_t sensor = 0; sensor < 4; ++sensor) {
        double largest = 0.0;
        double error = 0.0;
        // The first 5 ms after the release contain modes that no reading resolves.
        for (std::size_t k = 4 * 50 + sensor; k < derivatives.size(); k += 4) {
            const double expected = (beside[0][k] - beside[1][k]) / (2.0 * change);
            largest = std::max(largest, std::abs(expected));
            error = std::max(error, std::abs(expected - derivatives[k]));
        }
        EXPECT_GT(largest, 0.0);
        EXPECT_LT(error, allowed[sensor] * largest) << sensor;
    }
}

} // namespace
} // namespace culm::run
