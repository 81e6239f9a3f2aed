// SPDX-License-Identifier: BSD-3-Clause
// Uncertainty of the frequency and the decay of a calibrated chain, against beam theory and
// calibrations of stems that were stated otherwise.
#include "calibrate/calibration.hpp"
#include "physics/effects/library.hpp"
#include "support/parameter_ids.hpp"
#include "support/simulated_measurement.hpp"

#include <cmath>
#include <numbers>
#include <optional>
#include <string>

#include <gtest/gtest.h>

namespace culm::tests {
namespace {

/// Nothing that is stated is uncertain.
measure::StatedUncertainties exact() {
    measure::StatedUncertainties none;
    for (std::optional<double>* each : {&none.length, &none.diameter, &none.density, &none.scale,
                                        &none.clamp, &none.frames_per_second})
        *each = 0.0;
    return none;
}

measure::Measurement exactly_stated() {
    measure::Measurement measurement = simulated_measurement();
    measurement.uncertainties = exact();
    return measurement;
}

double relative_error(const calibrate::Calibration& found, const std::string& parameter) {
    const fit::FittedParameter& its = *found.part().find(id(parameter));
    return its.standard_error / its.value;
}

double relative_frequency_error(const calibrate::Calibration& found) {
    return found.frequency.standard_error / found.mode.frequency;
}

// ω = √(k/m) with every k proportional to Y, and a logarithmic decrement proportional to β.
TEST(ModeUncertainty, FollowsYAndBetaWhereOnlyTheNoiseCounts) {
    const calibrate::Calibration found = calibrate::calibrate_stem(exactly_stated());
    EXPECT_NEAR(relative_frequency_error(found) / relative_error(found, "bond_youngs_modulus"), 0.5,
                1e-3);
    EXPECT_NEAR(found.decay_per_cycle.standard_error / std::abs(found.mode.decay_per_cycle) /
                    relative_error(found, "bond_damping"),
                1.0, 0.01);
}

TEST(ModeUncertainty, DoesNotContainWhatTheStemIsStatedToBe) {
    const double by_noise = relative_frequency_error(calibrate::calibrate_stem(exactly_stated()));
    measure::Measurement measurement = exactly_stated();
    measurement.uncertainties.density = 0.05 * measurement.stem.density;
    measurement.uncertainties.diameter = 0.02 * 2.83e-3;
    const calibrate::Calibration found = calibrate::calibrate_stem(measurement);
    EXPECT_GT(relative_error(found, "bond_youngs_modulus"), 0.05);
    EXPECT_NEAR(relative_frequency_error(found) / by_noise, 1.0, 0.02);
}

TEST(ModeUncertainty, ContainsThatOfTheClock) {
    measure::Measurement measurement = exactly_stated();
    measurement.uncertainties.frames_per_second = 0.01;
    const calibrate::Calibration found = calibrate::calibrate_stem(measurement);
    EXPECT_NEAR(relative_frequency_error(found), 0.01, 1e-4);
}

/// A stem with a mass at its tip, which an effect states.
struct LoadedStem {
    static constexpr double tip_mass = 3e-5; // kg
    measure::Measurement measurement = empty_measurement();
    calibrate::CalibrationOptions options;

    LoadedStem() {
        options.effects = {physics::parse_effect("tip_mass(mass_kg=3e-5)", {})};
        measurement = read_with_noise(
            measurement,
            fit::with_effect(true_model(measurement, {}), options.effects.front(), measurement), 1);
        measurement.uncertainties = exact();
    }
    [[nodiscard]] calibrate::Calibration with_density(double density) const {
        measure::Measurement stated = measurement;
        stated.stem.density = density;
        return calibrate::calibrate_stem(stated, options);
    }
};

// The readings determine the frequency with the mass, Y/(0.2427 m + M) (Rayleigh). Without the mass
// it is Y/(0.2427 m), so that a share M/(0.2427 m + M) of an error of m remains.
TEST(ModeUncertainty, ContainsAStatedDensityWhereAnEffectCarriesAMass) {
    LoadedStem stem;
    const double density = stem.measurement.stem.density;
    constexpr double share = 0.04;
    const calibrate::Calibration exact = stem.with_density(density);
    const calibrate::Calibration below = stem.with_density((1.0 - share) * density);
    const calibrate::Calibration above = stem.with_density((1.0 + share) * density);
    const double by_density = 0.5 * (above.mode.frequency - below.mode.frequency);

    stem.measurement.uncertainties.density = share * density;
    const calibrate::Calibration found = stem.with_density(density);
    EXPECT_NEAR(found.frequency.standard_error /
                    std::hypot(exact.frequency.standard_error, by_density),
                1.0, 0.02);

    // The density is that of touching spheres.
    const double mass = 0.2427 * density * std::numbers::pi / 6.0 * std::pow(2.83e-3, 2) *
                        stem.measurement.stem.length;
    const double expected = 0.5 * share * LoadedStem::tip_mass / (mass + LoadedStem::tip_mass);
    EXPECT_GT(expected, 3.0 * relative_frequency_error(exact));
    EXPECT_NEAR(std::abs(by_density) / found.mode.frequency / expected, 1.0, 0.05);
}

} // namespace
} // namespace culm::tests
