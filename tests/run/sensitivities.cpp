// SPDX-License-Identifier: BSD-3-Clause
// Derivatives of the observed deflections against central differences of accurate runs.
#include "run/sensitivities.hpp"

#include "physics/effects/library.hpp"
#include "physics/effects/selection.hpp"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

namespace culm::run {
namespace {

CaseSpec filmed_stem(double youngs_modulus, double damping) {
    CaseSpec spec;
    spec.stem.bond_youngs_modulus = youngs_modulus;
    spec.stem.bond_damping = damping;
    spec.duration = 0.1;
    spec.sample_interval = 1e-3;
    spec.store = StoreLevel::Heights;
    spec.heights = {0.03, 0.07, 0.11, 0.14};
    return spec;
}

const CaseResult& completed(const CaseOutcome& outcome) {
    return std::get<CaseResult>(outcome);
}

/// d(deflection)/d(parameter) by a central difference of two runs at a tolerance of 1e-10.
std::vector<double> central_difference(const CaseSpec& spec, const CaseParameter& parameter) {
    // Third derivatives of some ten cycles by ln(parameter) are about (20)² times the first: the
    // error is 1e-8 · 400 / 6, below 1e-6. The errors of the two runs, 1e-9 each, add 1e-5.
    const double change = 1e-4 * parameter.get(spec);
    CaseSpec ahead = spec;
    CaseSpec behind = spec;
    ahead.integrator.relative_tolerance = behind.integrator.relative_tolerance = 1e-10;
    parameter.set(ahead, parameter.get(spec) + change);
    parameter.set(behind, parameter.get(spec) - change);
    const auto a = simulate(ahead);
    const auto b = simulate(behind);
    std::vector<double> out = completed(a).height_deflection;
    for (std::size_t k = 0; k < out.size(); ++k)
        out[k] = (out[k] - completed(b).height_deflection[k]) / (2 * change);
    return out;
}

class Sensitivities : public testing::TestWithParam<std::pair<double, double>> {};

TEST_P(Sensitivities, AgreeWithCentralDifferencesOfTightRuns) {
    CaseSpec spec = filmed_stem(GetParam().first, GetParam().second);
    spec.integrator.relative_tolerance = 1e-8;
    const auto parameters = baseline_parameters();
    const SensitivityOutcome outcome = simulate_with_sensitivities(spec, parameters);
    const auto& derivatives = std::get<CaseWithSensitivities>(outcome).height_derivatives;
    ASSERT_EQ(derivatives.size(), parameters.size());
    for (std::size_t p = 0; p < parameters.size(); ++p) {
        const auto expected = central_difference(spec, parameters[p]);
        double largest = 0.0;
        double worst = 0.0;
        for (std::size_t k = 0; k < expected.size(); ++k) {
            largest = std::max(largest, std::abs(expected[k]));
            worst = std::max(worst, std::abs(derivatives[p][k] - expected[k]));
        }
        EXPECT_LT(worst / largest, 1e-4) << to_string(parameters[p].id);
    }
}

INSTANTIATE_TEST_SUITE_P(LightAndHeavyDamping, Sensitivities,
                         testing::Values(std::pair{1e9, 1.0}, std::pair{1e9, 25.0},
                                         std::pair{4e9, 200.0}));

/// Derivative by a parameter of value zero, against a finite difference of accurate runs.
void expect_as_finite_difference(const CaseSpec& spec, const CaseParameter& parameter,
                                 double change) {
    const CaseParameter parameters[] = {parameter};
    CaseSpec changed = spec;
    parameter.set(changed, change);
    CaseSpec tight = spec;
    tight.integrator.relative_tolerance = changed.integrator.relative_tolerance = 1e-10;
    const auto outcome = simulate_with_sensitivities(spec, parameters);
    const auto& told = std::get<CaseWithSensitivities>(outcome).height_derivatives.front();
    const auto before = simulate(tight);
    const auto after = simulate(changed);
    double largest = 0.0;
    double worst = 0.0;
    for (std::size_t k = 0; k < told.size(); ++k) {
        const double expected =
            (completed(after).height_deflection[k] - completed(before).height_deflection[k]) /
            change;
        largest = std::max(largest, std::abs(expected));
        worst = std::max(worst, std::abs(told[k] - expected));
    }
    EXPECT_LT(worst / largest, 1e-4) << to_string(parameter.id);
}

CaseParameter effect_value(const physics::ParameterId& id, std::size_t place, double scale) {
    return {id, [place](const CaseSpec& spec) { return spec.effects.front().values[place]; },
            [place](CaseSpec& spec, double value) { spec.effects.front().values[place] = value; },
            scale};
}

TEST(Sensitivities, MatchFiniteDifferencesForASupportOfZeroAmplitude) {
    CaseSpec spec = filmed_stem(2.4e9, 160.0);
    spec.duration = 0.4;
    for (const physics::SelectedEffect& effect : physics::parse_effects("base_motion", {}))
        spec.effects.push_back(physics::with_defaults(effect, spec.stem));
    spec.effects.front().values = {0.0, 65.0, 0.0}; // amplitude, frequency, phase
    spec.integrator.relative_tolerance = 1e-8;
    expect_as_finite_difference(spec, effect_value({"base_motion", "amplitude_m", {}}, 0, 1e-3),
                                1e-5);
}

TEST(Sensitivities, MatchFiniteDifferencesForAShutterOfZeroReadoutTime) {
    CaseSpec spec = filmed_stem(2.4e9, 160.0);
    spec.sample_interval = 1e-4;
    for (const physics::SelectedEffect& effect : physics::parse_effects("rolling_shutter", {}))
        spec.effects.push_back(physics::with_defaults(effect, spec.stem));
    spec.effects.front().values = {0.0};
    spec.integrator.relative_tolerance = 1e-8;
    expect_as_finite_difference(spec, effect_value({"rolling_shutter", "readout_s", {}}, 0, 1e-3),
                                1e-7); // a one-sided difference: change · ω/2 of error
}

TEST(Sensitivities, DoNotChangeTheResultOfTheCase) {
    const CaseSpec spec = filmed_stem(2e9, 40.0);
    const auto outcome = simulate_with_sensitivities(spec, baseline_parameters());
    const CaseSpec alone[] = {spec};
    const auto plain = Simulator().simulate_together(alone);
    EXPECT_EQ(std::get<CaseWithSensitivities>(outcome).result.height_deflection,
              completed(plain.front()).height_deflection);
}

TEST(Sensitivities, AreComputedInBatchesForMoreParametersThanLanes) {
    const CaseSpec spec = filmed_stem(2e9, 40.0);
    std::vector<CaseParameter> many;
    for (int k = 0; k < 4; ++k)
        for (const CaseParameter& parameter : baseline_parameters())
            many.push_back(parameter);
    const auto outcome = simulate_with_sensitivities(spec, many);
    const auto& derivatives = std::get<CaseWithSensitivities>(outcome).height_derivatives;
    ASSERT_EQ(derivatives.size(), 12U);
    for (std::size_t p = 3; p < derivatives.size(); ++p)
        EXPECT_EQ(derivatives[p], derivatives[p % 3]);
}

TEST(Sensitivities, ReportTheFailureOfACaseWithoutASolution) {
    CaseSpec spec = filmed_stem(1e9, 25.0);
    spec.tip_deflection = std::nan("");
    EXPECT_TRUE(std::holds_alternative<CaseFailure>(
        simulate_with_sensitivities(spec, baseline_parameters())));
}

} // namespace
} // namespace culm::run
