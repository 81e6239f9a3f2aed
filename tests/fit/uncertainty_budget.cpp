// SPDX-License-Identifier: BSD-3-Clause
#include "fit/solve/uncertainty_budget.hpp"

#include "diagnose/ladder.hpp"
#include "fit/fit_model.hpp"
#include "physics/effects/library.hpp"
#include "support/parameter_ids.hpp"
#include "support/simulated_measurement.hpp"

#include <algorithm>
#include <cmath>
#include <random>
#include <span>

#include <gtest/gtest.h>

namespace culm::tests {
namespace {

/// The published chain, as `culm calibrate` fits it, and its budget.
struct FittedStem {
    fit::RecordingFit fit;
    fit::UncertaintyBudget budget;
};

FittedStem fitted(const measure::Measurement& measurement) {
    const fit::Fit fit = fit::fit_baseline({&measurement, 1}).fit;
    return {fit.parts.front(), fit::uncertainty_budget(fit, measurement)};
}

std::size_t place_of(const fit::RecordingFit& fit, const physics::ParameterId& id) {
    return static_cast<std::size_t>(fit.find(id) - fit.parameters.data());
}

const fit::BudgetInput& line_of(const fit::UncertaintyBudget& budget, const std::string& name) {
    return *std::ranges::find(budget.inputs, name,
                              [](const fit::BudgetInput& line) { return line.input.name; });
}

/// d ln Y/d ln x of an input.
double exponent(const fit::UncertaintyBudget& budget, const fit::RecordingFit& fit,
                const std::string& input) {
    const fit::BudgetInput line = line_of(budget, input);
    return line.sensitivities[place_of(fit, physics::bond_youngs_modulus)] * line.input.value /
           fit.find(physics::bond_youngs_modulus)->value;
}

// The frequency of a slender beam determines only Y I/(m' L⁴).
TEST(UncertaintyBudget, FollowsTheFrequencyOfABeamForTheModulus) {
    measure::Measurement measurement = simulated_measurement();
    // The readings improve a length that is known to 0.3 mm, but not one that is known to 0.01 mm.
    measurement.uncertainties.length = 0.01e-3;
    const auto [fit, budget] = fitted(measurement);
    EXPECT_NEAR(exponent(budget, fit, "length"), 4.0, 0.05);
    EXPECT_NEAR(exponent(budget, fit, "diameter"), -2.0, 0.02); // m' ∝ d², I ∝ d⁴
    EXPECT_NEAR(exponent(budget, fit, "density"), 1.0, 0.01);
    // (4 · 0.01/155.65)² + (2 · 1 %)² + (1 %)², the last two by default.
    const std::size_t modulus = place_of(fit, physics::bond_youngs_modulus);
    EXPECT_NEAR(budget.combined[modulus] / fit.parameters[modulus].value,
                std::sqrt(std::pow(4.0 * 0.01 / 155.65, 2) + 5e-4), 3e-4);
}

// The decay by drag determines only C_d d/m', with m' = π ρ d²/6.
TEST(UncertaintyBudget, FollowsDensityAndDiameterForADragCoefficient) {
    measure::Measurement measurement = empty_measurement();
    const auto drag = physics::parse_effects("quadratic_drag", {});
    const fit::StemModel truth = fit::with_effect(
        true_model(measurement, {}),
        physics::parse_effect("quadratic_drag(drag_coefficient=1.5)", {}), measurement);
    measurement = read_with_noise(measurement, truth, 3);
    const diagnose::NestedFits fits = diagnose::fit_nested({&measurement, 1}, {drag});
    const fit::RecordingFit& fit = fits.models.back().parts.front();
    const fit::UncertaintyBudget budget = fit::uncertainty_budget(fits.models.back(), measurement);
    const std::size_t place = place_of(fit, id("quadratic_drag.drag_coefficient"));
    for (const char* const input : {"density", "diameter"}) {
        const fit::BudgetInput line = line_of(budget, input);
        EXPECT_NEAR(line.sensitivities[place] * line.input.value / fit.parameters[place].value, 1.0,
                    0.03)
            << input;
    }
}

TEST(UncertaintyBudget, HasSharesThatSumToOneForEachParameter) {
    measure::Measurement measurement = simulated_measurement();
    measurement.uncertainties.frames_per_second = 1e-4;
    const auto [fit, budget] = fitted(measurement);
    ASSERT_EQ(budget.inputs.size(), 8U); // six stated inputs and the second mode
    EXPECT_TRUE(budget.inputs.back().input.name.starts_with("loss of mode 2"));
    for (std::size_t p = 0; p < budget.combined.size(); ++p) {
        double sum = budget.share_of_readings(p);
        for (std::size_t k = 0; k < budget.inputs.size(); ++k)
            sum += budget.share(k, p);
        EXPECT_NEAR(sum, 1.0, 1e-9) << p;
    }
}

/// The measurement as a person states it whose value of the input is larger by `change`.
measure::Measurement restated(measure::Measurement measurement, const std::string& input,
                              double change) {
    auto& circle = std::get<measure::CircularSection>(measurement.stem.section);
    if (input == "length")
        measurement.stem.length += change;
    else if (input == "diameter")
        circle.diameter += change;
    else if (input == "wall")
        *circle.wall += change;
    else if (input == "density")
        measurement.stem.density += change;
    else if (input == "mass at 100 mm")
        measurement.stem.added_masses.front().mass += change;
    for (double& height : measurement.heights)
        height = input == "scale"          ? height * (1.0 + change)
                 : input == "clamp height" ? height + change
                                           : height;
    for (double& reading : measurement.deflections)
        reading *= input == "scale" ? 1.0 + change : 1.0;
    for (double& time : measurement.times)
        time /= input == "frame rate" ? 1.0 + change : 1.0;
    return measurement;
}

// Compares with fits of the restated measurement, which do not use the budget's derivatives.
TEST(UncertaintyBudget, HasTheSensitivitiesOfFitsToRestatedInputs) {
    measure::Measurement measurement = empty_measurement();
    std::get<measure::CircularSection>(measurement.stem.section).wall = 0.4e-3;
    measurement.stem.added_masses = {{0.1, 2e-5, {}}};
    measurement.uncertainties.frames_per_second = 1e-3;
    measurement = read_with_noise(measurement, true_model(measurement, {}), 3);
    const auto [fit, budget] = fitted(measurement);
    ASSERT_EQ(budget.inputs.size(), 10U);
    EXPECT_TRUE(budget.inputs.back().input.name.starts_with("loss of mode 2"));
    for (const fit::BudgetInput& line : std::span(budget.inputs).first(8)) { // that were stated
        // A tenth of u either way: the fit is linear there.
        const double change = 0.1 * line.input.standard_uncertainty;
        const fit::RecordingFit above = fitted(restated(measurement, line.input.name, change)).fit;
        const fit::RecordingFit below = fitted(restated(measurement, line.input.name, -change)).fit;
        for (std::size_t p = 0; p < budget.combined.size(); ++p) {
            const double by_refit =
                (above.parameters[p].value - below.parameters[p].value) / (2.0 * change);
            // Fits end within a hundredth of a standard error.
            const double tolerance = 0.02 * std::abs(by_refit) +
                                     0.02 * fit.parameters[p].standard_error / (2.0 * change);
            EXPECT_NEAR(line.sensitivities[p], by_refit, tolerance)
                << line.input.name << " " << to_string(fit.parameters[p].id);
        }
    }
}

TEST(UncertaintyBudget, PullsAnInputTowardsTheValueThatMadeTheReadings) {
    measure::Measurement truth = empty_measurement();
    truth.noise = 0.01e-3;
    const double wrong = 1e-3; // m: five times the default
    measure::Measurement stated = read_with_noise(truth, true_model(truth, {}), 5);
    for (double& height : stated.heights)
        height -= wrong;
    const fit::UncertaintyBudget budget = fitted(stated).budget;
    const fit::BudgetInput clamp = line_of(budget, "clamp height");
    EXPECT_GT(clamp.pull, 3.0);
    EXPECT_LT(clamp.uncertainty_with_readings, clamp.input.standard_uncertainty);
    // Y absorbs the whole effect of the density on the frequency.
    EXPECT_NEAR(line_of(budget, "density").pull, 0.0, 0.05);
    EXPECT_NEAR(line_of(budget, "density").uncertainty_with_readings, 1.25, 0.01);
}

TEST(UncertaintyBudget, CoversTheTruthWhenInputsAreAsUncertainAsStated) {
    const TrueValues truth;
    std::mt19937 generator(11);
    std::normal_distribution<double> normal;
    double modulus = 0.0;
    double damping = 0.0;
    constexpr int records = 24;
    for (unsigned seed = 1; seed <= records; ++seed) {
        const measure::Measurement real = simulated_measurement(truth, seed);
        measure::Measurement stated = real;
        for (const fit::StatedInput& input : fit::stated_inputs(real))
            stated = restated(stated, input.name, input.standard_uncertainty * normal(generator));
        const FittedStem stem = fitted(stated);
        const auto squared = [&](const physics::ParameterId& id, double value) {
            const std::size_t p = place_of(stem.fit, id);
            return std::pow((stem.fit.parameters[p].value - value) / stem.budget.combined[p], 2);
        };
        modulus += squared(physics::bond_youngs_modulus, truth.bond_youngs_modulus);
        damping += squared(physics::bond_damping, truth.bond_damping);
    }
    // χ² with 24 degrees of freedom lies in 8.5 … 48 with a probability of 99.7 %.
    for (const double sum : {modulus, damping}) {
        EXPECT_GT(sum, 8.5);
        EXPECT_LT(sum, 48.0);
    }
}

TEST(StatedInputs, AreTheDimensionsOfOtherSections) {
    measure::Measurement measurement = empty_measurement();
    measurement.stem.section = measure::RectangularSection{4e-3, 2e-3};
    measurement.uncertainties.section_height = 1e-5;
    const auto names = [&] {
        std::string text;
        for (const fit::StatedInput& input : fit::stated_inputs(measurement))
            text += input.name + (input.is_default ? "*, " : ", ");
        return text;
    };
    EXPECT_EQ(names(),
              "length*, section width*, section height, density*, scale*, clamp height*, ");
    measurement.stem.section = measure::GeneralSection{8e-6, 3e-12};
    EXPECT_EQ(names(),
              "length*, section area*, second moment of area*, density*, scale*, clamp height*, ");
}

// A mass that is written as 0.05 g is known less well than one written as 0.0500 g.
TEST(StatedInputs, GiveAMassToHalfItsLastDigitAtBest) {
    const auto uncertainty = [](const measure::AddedMass& added) {
        measure::Measurement measurement = empty_measurement();
        measurement.stem.added_masses = {added};
        const std::vector<fit::StatedInput> inputs = fit::stated_inputs(measurement);
        return std::ranges::find(inputs, "mass at 100 mm", &fit::StatedInput::name)
            ->standard_uncertainty;
    };
    EXPECT_DOUBLE_EQ(uncertainty({0.1, 5e-5, {}, 1e-5}), 5e-6);
    EXPECT_DOUBLE_EQ(uncertainty({0.1, 5e-5, {}, 1e-8}), 5e-7);
    EXPECT_DOUBLE_EQ(uncertainty({0.1, 5e-5, 2e-7, 1e-5}), 2e-7);
}

TEST(StatedInputs, DivideTheStemOfTheOtherValueAgain) {
    for (const measure::Section& section :
         {measure::Section(measure::CircularSection{2.83e-3, 0.4e-3}),
          measure::Section(measure::RectangularSection{4e-3, 2e-3}),
          measure::Section(measure::GeneralSection{8e-6, 3e-12})}) {
        measure::Measurement measurement = empty_measurement();
        measurement.stem.section = section;
        measurement.stem.added_masses = {{0.1, 2e-5, {}}};
        for (const fit::StatedInput& input : fit::stated_inputs(measurement)) {
            if (input.acts != fit::InputActs::OnChain)
                continue;
            run::CaseSpec spec = fit::chain_of(measurement).spec;
            const double error = 2.0 * input.standard_uncertainty;
            input.access.set(spec, error);
            measure::Measurement other = measurement;
            input.number(other.stem) += error;
            const run::CaseSpec wanted = fit::chain_of(other).spec;
            EXPECT_DOUBLE_EQ(spec.stem.bond_length, wanted.stem.bond_length) << input.name;
            EXPECT_DOUBLE_EQ(spec.stem.sphere_mass(), wanted.stem.sphere_mass()) << input.name;
            EXPECT_DOUBLE_EQ(spec.stem.bond_outer_diameter, wanted.stem.bond_outer_diameter);
            EXPECT_DOUBLE_EQ(spec.stem.bond_inner_diameter, wanted.stem.bond_inner_diameter);
            EXPECT_DOUBLE_EQ(spec.added_masses[0].mass, wanted.added_masses[0].mass) << input.name;
        }
    }
}

} // namespace
} // namespace culm::tests
