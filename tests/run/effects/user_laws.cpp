// SPDX-License-Identifier: BSD-3-Clause
// A formula with the law of a library effect gives the same motion as that effect.
#include "free_vibration.hpp"
#include "physics/effects/user_effect.hpp"

#include <gtest/gtest.h>

namespace culm::run {
namespace {

physics::ActiveEffect formula(physics::UserLawKind kind, const std::string& text, double value) {
    physics::UserEffectText effect;
    effect.name = "mine";
    effect.kind = kind;
    effect.formula = text;
    effect.parameters = {{.name = "c",
                          .unit = "",
                          .meaning = "of the formula",
                          .default_value = value,
                          .lower = std::min(0.0, 2.0 * value),
                          .upper = std::max(0.0, 2.0 * value),
                          .scale = 1.0}};
    return {physics::make_user_effect(effect), {value}};
}

/// Largest difference of the two motions over the largest change by the library's effect.
double disagreement(CaseSpec spec, const physics::ActiveEffect& user,
                    const physics::ActiveEffect& library) {
    const Swing bare = swing(spec, 5.0);
    spec.effects = {user};
    const Swing by_user = swing(spec, 5.0);
    spec.effects = {library};
    const Swing by_library = swing(spec, 5.0);
    double difference = 0.0;
    double effect = 0.0;
    for (std::size_t i = 0; i < bare.values.size(); ++i) {
        difference = std::max(difference, std::abs(by_user.values[i] - by_library.values[i]));
        effect = std::max(effect, std::abs(by_library.values[i] - bare.values[i]));
    }
    return difference / effect;
}

TEST(UsersForce, ReproducesQuadraticDrag) {
    CaseSpec spec = slender_case();
    set_damping_ratio(spec, 0.005);
    const double coefficient = 50.0;
    const double per_length = 0.5 * 1.2 * coefficient * spec.stem.bond_outer_diameter;
    // The formula acts sideways only, the library's drag along the whole velocity. The difference
    // is the square of the slope, below 1e-4.
    EXPECT_LT(disagreement(spec,
                           formula(physics::UserLawKind::ForcePerLength, "-c*abs(v)*v", per_length),
                           active("quadratic_drag", {coefficient})),
              1e-4);
}

TEST(UsersMoment, ReproducesTheBendingNonlinearity) {
    CaseSpec spec = slender_case();
    set_damping_ratio(spec, 0.005);
    const double gamma = 0.3;
    // Both are the same law. They differ by the error of the integrator, 1e-8 of the pull per step;
    // the effect is a thousandth of the pull or more.
    EXPECT_LT(disagreement(spec,
                           formula(physics::UserLawKind::BendingMoment, "c*kappa^3",
                                   gamma * physics::bending_rigidity(spec.stem)),
                           active("bending_nonlinearity", {gamma})),
              1e-3);
}

TEST(UsersMomentAtTheClamp, ReproducesTheCompliantClamp) {
    CaseSpec spec = slender_case();
    set_damping_ratio(spec, 0.005);
    const double stiffness = 10.0 * physics::stiffness_scale(spec.stem);
    EXPECT_LT(disagreement(spec, formula(physics::UserLawKind::BaseMoment, "-c*theta", stiffness),
                           active("clamp_compliance", {stiffness, 0.0})),
              1e-5);
}

TEST(UsersFormula, FailsOnlyTheLaneInWhichItHasNoValue) {
    std::vector<CaseSpec> specs(3, slender_case());
    for (CaseSpec& spec : specs) {
        set_damping_ratio(spec, 0.005);
        // The formula has a value while the stem is held, but not at the far end of a large swing.
        spec.effects = {formula(physics::UserLawKind::ForcePerLength, "c*sqrt(0.011 + x)", 1e-6)};
        spec.tip_deflection = 5e-3;
        spec.duration = 1.0;
        spec.sample_interval = 1e-3;
    }
    specs[1].tip_deflection = 20e-3;
    const std::vector<CaseOutcome> outcomes = Simulator().simulate_together(specs);
    ASSERT_EQ(outcomes.size(), 3U);
    ASSERT_TRUE(std::holds_alternative<CaseFailure>(outcomes[1]));
    EXPECT_EQ(std::get<CaseFailure>(outcomes[1]).kind, core::FailureKind::UserExpression);
    const std::vector<CaseOutcome> alone = Simulator().simulate_together({specs.data(), 1});
    for (const std::size_t k : {0U, 2U}) {
        ASSERT_TRUE(std::holds_alternative<CaseResult>(outcomes[k]));
        EXPECT_EQ(std::get<CaseResult>(outcomes[k]).tip_deflection,
                  std::get<CaseResult>(alone[0]).tip_deflection);
    }
}

TEST(UsersFormula, ReportsItsInputsIfItHasNoValue) {
    CaseSpec spec = slender_case();
    spec.tip_deflection = 20e-3; // beyond the values tried when the formula is read
    spec.effects = {formula(physics::UserLawKind::ForcePerLength, "c*sqrt(0.015 - x)", 1e-6)};
    spec.duration = 0.1;
    spec.sample_interval = 1e-3;
    const CaseOutcome outcome = simulate(spec);
    ASSERT_TRUE(std::holds_alternative<CaseFailure>(outcome));
    const auto& failure = std::get<CaseFailure>(outcome);
    EXPECT_EQ(failure.kind, core::FailureKind::UserExpression) << failure.reason;
    EXPECT_NE(failure.reason.find("c*sqrt(0.015 - x) is not a number at s = "), std::string::npos)
        << failure.reason;
}

} // namespace
} // namespace culm::run
