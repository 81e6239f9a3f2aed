// SPDX-License-Identifier: BSD-3-Clause
// Every effect of the library: all integrators, lanes and derivatives agree.
#include "free_vibration.hpp"
#include "physics/effects/stem_scales.hpp"
#include "run/sensitivities.hpp"

#include <gtest/gtest.h>

namespace culm::run {
namespace {

/// A coarse stem, so that the explicit integrator needs few steps; two periods of mode 1.
CaseSpec coarse_case() {
    CaseSpec spec = coarse_stem();
    set_damping_ratio(spec, 0.01);
    spec.integrator.relative_tolerance = 1e-9;
    spec.store = StoreLevel::Heights;
    spec.heights = {0.05, 0.10, 0.14};
    const double period = 1.0 / physics::first_frequency(spec.stem);
    spec.sample_interval = period / 40.0;
    spec.duration = 80.0 * spec.sample_interval;
    return spec;
}

const CaseResult& completed(const CaseOutcome& outcome) {
    if (const auto* failure = std::get_if<CaseFailure>(&outcome))
        throw std::runtime_error(failure->reason);
    return std::get<CaseResult>(outcome);
}

double largest_difference(const std::vector<double>& a, const std::vector<double>& b) {
    double largest = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i)
        largest = std::max(largest, std::abs(a[i] - b.at(i)));
    return largest;
}

class EveryEffect : public testing::TestWithParam<std::string> {
  protected:
    /// The effect with default parameters for the stem.
    static CaseSpec with_effect() { return with_default_effect(coarse_case(), GetParam()); }
};

TEST_P(EveryEffect, IsTheSameExplicitlyAndImplicitly) {
    const CaseSpec spec = with_effect();
    const CaseOutcome implicit = simulate(spec);
    CaseSpec stepped = spec;
    stepped.integrator.method = IntegrationMethod::Explicit;
    // Effects may lower the limit of the plain chain, but not by this factor.
    stepped.integrator.timestep =
        spec.sample_interval /
        std::ceil(spec.sample_interval / (0.2 * largest_stable_timestep(coarse_case())));
    const CaseOutcome explicitly = simulate(stepped);
    const CaseOutcome bare = simulate(coarse_case());
    const double difference = largest_difference(completed(implicit).height_deflection,
                                                 completed(explicitly).height_deflection);
    // Verlet's error is (ω dt)²/24 per radian: below 1e-5 in the modes that matter here.
    EXPECT_LT(difference, 5e-5 * spec.tip_deflection);
    EXPECT_GT(largest_difference(completed(implicit).height_deflection,
                                 completed(bare).height_deflection),
              20.0 * difference);
}

TEST_P(EveryEffect, IsTheSameWithSundials) {
    const CaseSpec spec = with_effect();
    const auto own = completed(simulate(spec)).height_deflection;
    CaseSpec other = spec;
    other.integrator.method = IntegrationMethod::Sundials;
    EXPECT_LT(largest_difference(own, completed(simulate(other)).height_deflection),
              2e-6 * spec.tip_deflection);
}

TEST_P(EveryEffect, IsTheSameInLanes) {
    std::vector<CaseSpec> specs(3, with_effect());
    for (std::size_t k = 0; k < specs.size(); ++k)
        for (double& value : specs[k].effects.front().values)
            value *= 1.0 - 0.1 * static_cast<double>(k);
    for (CaseSpec& spec : specs)
        spec.integrator.relative_tolerance = 1e-6;
    ASSERT_TRUE(can_share_lanes(specs[0], specs[1]));
    const auto together = Simulator().simulate_together(specs);
    for (std::size_t k = 0; k < specs.size(); ++k) {
        // Lanes and scalars sum in a different order, which causes rounding differences. Where
        // friction changes its sign or a joint turns back within a step, the choice of the next
        // step amplifies them.
        const bool is_dry = GetParam() == "clamp_friction" || GetParam() == "clamp_slip";
        const double magnified = is_dry ? 100.0 : 1.0;
        EXPECT_LT(largest_difference(completed(together[k]).height_deflection,
                                     completed(simulate(specs[k])).height_deflection),
                  1e-9 * magnified * specs[k].tip_deflection);
    }
}

/// d(deflection)/d(parameter) from four runs at a tolerance of 1e-11, with an error of fourth
/// order.
std::vector<double> five_point_difference(CaseSpec spec, const CaseParameter& parameter,
                                          double change) {
    spec.integrator.relative_tolerance = 1e-11;
    const double value = parameter.get(spec);
    std::vector<double> sum;
    for (const auto& [place, weight] : {std::pair{-2, 1.0}, {-1, -8.0}, {1, 8.0}, {2, -1.0}}) {
        parameter.set(spec, value + place * change);
        const CaseOutcome outcome = simulate(spec);
        sum.resize(completed(outcome).height_deflection.size());
        for (std::size_t i = 0; i < sum.size(); ++i)
            sum[i] += weight * completed(outcome).height_deflection[i] / (12.0 * change);
    }
    return sum;
}

TEST_P(EveryEffect, HasTheDerivativesOfItsParameters) {
    CaseSpec spec = with_effect();
    spec.integrator.relative_tolerance = 1e-8;
    const auto described = spec.effects.front().effect->parameters_for(spec.stem);
    std::vector<CaseParameter> parameters;
    for (std::size_t p = 0; p < described.size(); ++p)
        parameters.push_back(
            {{spec.effects.front().effect->name, described[p].name, {}},
             [p](const CaseSpec& of) { return of.effects.front().values[p]; },
             [p](CaseSpec& of, double value) { of.effects.front().values[p] = value; },
             described[p].scale});
    const SensitivityOutcome outcome = simulate_with_sensitivities(spec, parameters);
    ASSERT_TRUE(std::holds_alternative<CaseWithSensitivities>(outcome));
    const auto& derivatives = std::get<CaseWithSensitivities>(outcome).height_derivatives;
    for (std::size_t p = 0; p < parameters.size(); ++p) {
        const double change = 1e-2 * described[p].scale;
        const std::vector<double> expected = five_point_difference(spec, parameters[p], change);
        double largest = 0.0;
        double worst = 0.0;
        for (std::size_t i = 0; i < derivatives[p].size(); ++i) {
            largest = std::max(largest, std::abs(expected[i]));
            worst = std::max(worst, std::abs(derivatives[p][i] - expected[i]));
        }
        // Each run of the difference is accurate to about 1e-10 of the pull.
        const double noise = 2e-10 * spec.tip_deflection / change;
        // The lanes of a derivative take the same steps over a kink.
        const double allowed = is_kinked(GetParam()) ? 3e-3 : 1e-4;
        EXPECT_LT(worst, allowed * largest + noise) << to_string(parameters[p].id);
        EXPECT_TRUE(largest > 100.0 * noise || !described[p].calibrated)
            << to_string(parameters[p].id);
    }
}

INSTANTIATE_TEST_SUITE_P(Library, EveryEffect, testing::ValuesIn(physics::effect_names()),
                         [](const auto& of) { return of.param; });

} // namespace
} // namespace culm::run
