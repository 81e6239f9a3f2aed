// SPDX-License-Identifier: BSD-3-Clause
// Formulas of users: values, limits, and messages that mark the mistake.
#include "physics/effects/user_effect.hpp"

#include "core/error.hpp"
#include "core/lanes.hpp"
#include "effect_bench.hpp"

#include <cmath>
#include <numbers>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace culm::physics {
namespace {

using testing::EndsWith;
using testing::HasSubstr;
using testing::StartsWith;

double value(const std::string& formula, const UserLawInputs& inputs = {},
             const std::vector<double>& parameters = {1.0, 2.0}) {
    return (*compile_expression({"mine", UserLawKind::ForcePerLength, formula, {"c", "p"}}))(
        inputs, parameters);
}

std::string refusal_of_formula(const std::string& formula,
                               UserLawKind kind = UserLawKind::ForcePerLength) {
    try {
        static_cast<void>(compile_expression({"mine", kind, formula, {"c", "p"}}));
    } catch (const core::InputError& error) {
        return error.what();
    }
    return "";
}

EffectParameter parameter(const std::string& name, double standard, double lower, double upper) {
    return {.name = name,
            .unit = "",
            .meaning = "of the formula",
            .default_value = standard,
            .lower = lower,
            .upper = upper,
            .scale = 1.0};
}

UserEffectText any_power_drag() {
    UserEffectText text;
    text.name = "any_power_drag";
    text.formula = "-c*abs(v)^p*sign(v)";
    text.parameters = {parameter("c", 2e-3, 0.0, 1.0), parameter("p", 2.0, 0.5, 4.0)};
    return text;
}

TEST(Formula, UsesInputsAndParameters) {
    const UserLawInputs inputs{.position = 0.1,
                               .deflection = 0.02,
                               .velocity = -3.0,
                               .curvature = 4.0,
                               .curvature_rate = 50.0,
                               .time = 0.6};
    EXPECT_EQ(value("s", inputs), 0.1);
    EXPECT_EQ(value("x", inputs), 0.02);
    EXPECT_EQ(value("v", inputs), -3.0);
    EXPECT_EQ(value("kappa", inputs), 4.0);
    EXPECT_EQ(value("kappa_rate", inputs), 50.0);
    EXPECT_EQ(value("t", inputs), 0.6);
    EXPECT_EQ(value("c + 10*p", inputs, {3.0, 4.0}), 43.0);
    // The parser may take powers by repeated products.
    EXPECT_NEAR(value("-c*abs(v)^p*sign(v)", inputs, {0.5, 1.7}), 0.5 * std::pow(3.0, 1.7), 1e-14);
}

TEST(Formula, UsesAngleAndRateForAMomentAtTheClamp) {
    const auto formula = compile_expression({"mine",
                                             UserLawKind::BaseMoment,
                                             "theta + 10*omega + "
                                             "100*t",
                                             {}});
    const UserLawInputs inputs{.position = 0.0,
                               .deflection = 1.0,
                               .velocity = 2.0,
                               .curvature = 0.0,
                               .curvature_rate = 0.0,
                               .time = 3.0};
    EXPECT_EQ((*formula)(inputs, {}), 321.0);
}

TEST(Formula, HasTheFunctionsThatItNames) {
    for (const std::string& name : expression_functions())
        EXPECT_TRUE(std::isfinite(value(name + "(0.5)"))) << name;
    EXPECT_EQ(value("ln(exp(2))"), 2.0);
    EXPECT_EQ(value("log10(1000)"), std::log10(1000.0));
    EXPECT_EQ(value("min(3, 1, 2) + 10*max(3, 1)"), 31.0);
    EXPECT_EQ(value("cos(pi)"), -1.0);
    EXPECT_EQ(value("sign(-2) + 10*sign(0) + 100*sign(5)"), 99.0);
    EXPECT_EQ(value("t < 1 ? 2 : 3"), 2.0);
}

TEST(Formula, ReportsItsInputsWhereItHasNoValue) {
    try {
        value("sqrt(x)*c", {.position = 0.1, .deflection = -0.02});
        FAIL();
    } catch (const core::NumericalError& error) {
        EXPECT_EQ(error.kind(), core::FailureKind::UserExpression);
        EXPECT_STREQ(core::to_string(error.kind()), "user_expression");
        EXPECT_STREQ(error.what(), "effect mine: sqrt(x)*c is not a number at s = 0.1, x = -0.02, "
                                   "v = 0, kappa = 0, kappa_rate = 0, t = 0, c = 1, p = 2");
    }
    EXPECT_THROW(value("1/x"), core::NumericalError);
}

TEST(Mistake, IsReportedWithTheNearestNameAndACaret) {
    EXPECT_THAT(refusal_of_formula("-c*abs(v)*kapa"),
                StartsWith("unknown name \"kapa\" (did you mean \"kappa\"?); there are s, x, v, "
                           "kappa, kappa_rate, t, c, p, pi, and the functions abs, sign, "));
    EXPECT_THAT(refusal_of_formula("-c*abs(v)*kapa"),
                EndsWith("\n    -c*abs(v)*kapa\n              ^"));
    EXPECT_THAT(refusal_of_formula("-c*abz(v)"), HasSubstr("\"abz\" (did you mean \"abs\"?)"));
    EXPECT_THAT(refusal_of_formula("log(2 + v^2)"),
                HasSubstr("unknown name \"log\" (did you mean \"ln\"?)"));
    EXPECT_THAT(refusal_of_formula("v", UserLawKind::BaseMoment),
                HasSubstr("there are theta, omega, t, c"));
}

TEST(Mistake, IsMarkedWithACaretIfItIsInTheSyntax) {
    EXPECT_THAT(refusal_of_formula("c*(v + 1"), EndsWith("\n    c*(v + 1\n            ^"));
    EXPECT_THAT(refusal_of_formula("c*(v + 1"), StartsWith("a closing parenthesis is missing"));
    EXPECT_THAT(refusal_of_formula("c*"), StartsWith("the formula ends too early"));
    EXPECT_THAT(refusal_of_formula("c v"), EndsWith("\n    c v\n      ^"));
    EXPECT_THAT(refusal_of_formula("c*)v"), EndsWith("\n    c*)v\n      ^"));
    EXPECT_THAT(refusal_of_formula("c*/v"), EndsWith("\n    c*/v\n      ^"));
    EXPECT_THAT(refusal_of_formula("3 $ v"), EndsWith("\n    3 $ v\n      ^"));
}

TEST(Mistake, IsFoundEvenIfAParserWouldAcceptIt) {
    EXPECT_THAT(refusal_of_formula("v = 3"),
                StartsWith("nothing can be assigned here; == compares"));
    EXPECT_THAT(refusal_of_formula("v = 3"), EndsWith("\n    v = 3\n      ^"));
    EXPECT_EQ(refusal_of_formula("(v >= 3) + (v <= 2) + (v != 1) + (v == 0)"), "");
    EXPECT_THAT(refusal_of_formula("-0,5*v"),
                StartsWith("must be one formula; a decimal number needs a "
                           "point"));
    EXPECT_THAT(refusal_of_formula("c*\"a\""), StartsWith("text is not allowed"));
    EXPECT_THAT(refusal_of_formula("c*κ"), StartsWith("only plain characters are allowed"));
    EXPECT_EQ(refusal_of_formula("  "), "the formula is empty");
    EXPECT_EQ(refusal_of_formula(std::string(1001, '1')),
              "the formula has 1001 characters; 1000 are allowed");
    EXPECT_THAT(refusal_of_formula(std::string(51, '(') + "v" + std::string(51, ')')),
                StartsWith("parentheses are nested deeper than 50"));
    EXPECT_EQ(refusal_of_formula(std::string(50, '(') + "v" + std::string(50, ')')), "");
}

TEST(UserEffect, BecomesALawOfTheChain) {
    const EffectPointer effect = make_user_effect(any_power_drag());
    EXPECT_EQ(effect->law, "sideways force per length, N/m: -c*abs(v)^p*sign(v)");
    EffectBench bench({{effect, {1e-3, 2.0}}, active("taper", {0.1})});
    ASSERT_EQ(bench.model.user_laws.size(), 1U);
    const UserLaw<double>& law = bench.model.user_laws[0];
    EXPECT_NEAR(user_law_value(law, {.velocity = 3.0}), -9e-3, 1e-16); // a rounding
    // The central difference with a step of 1e-6: its error is (1e-6)² of the curvature.
    EXPECT_NEAR(user_law_slope(law, {.velocity = 3.0}, &UserLawInputsOf<double>::velocity, 1.0),
                -6e-3, 1e-9);
}

TEST(UserEffect, IsTheSameInEveryLane) {
    const EffectPointer effect = make_user_effect(any_power_drag());
    EffectBench bench({{effect, {1e-3, 2.0}}});
    UserLaw<core::Lanes> law{UserLawKind::ForcePerLength,
                             bench.model.user_laws[0].expression,
                             {core::Lanes(1e-3), core::Lanes([](int k) { return 2.0 + 0.1 * k; })}};
    UserLawInputsOf<core::Lanes> inputs;
    inputs.velocity = core::Lanes([](int k) { return 1.0 + k; });
    const core::Lanes values = user_law_value(law, inputs);
    for (std::size_t k = 0; k < core::lane_count; ++k) {
        const double lane = static_cast<double>(k);
        EXPECT_EQ(core::lane(values, k),
                  value("-c*abs(v)^p*sign(v)", {.velocity = 1.0 + lane}, {1e-3, 2.0 + 0.1 * lane}));
    }
}

TEST(UserEffect, IsRefusedWithoutAValueAtRestOrAtABound) {
    const auto message = [](UserEffectText text) -> std::string {
        try {
            static_cast<void>(make_user_effect(std::move(text)));
        } catch (const core::InputError& error) {
            return error.what();
        }
        return "";
    };
    UserEffectText text = any_power_drag();
    text.formula = "-c*v/abs(v)*p";
    EXPECT_THAT(message(text),
                StartsWith("effect any_power_drag: -c*v/abs(v)*p is not a number at s = "
                           "0, x = 0, v = 0, "));
    text.formula = "-c*(v + 3)/(p - 0.5)";
    EXPECT_THAT(message(text), HasSubstr("is infinite at"));
    EXPECT_THAT(message(text), HasSubstr("p = 0.5"));
    text.formula = "-c*sqrt(x)*p";
    EXPECT_THAT(message(text), HasSubstr("x = -0.01"));
}

TEST(UserEffect, NeedsNamesThatMeanNothingElse) {
    EXPECT_EQ(effect_name_fault("my_drag2"), "");
    EXPECT_NE(effect_name_fault("taper"), "");
    EXPECT_NE(effect_name_fault("My drag"), "");
    EXPECT_NE(effect_name_fault(""), "");
    EXPECT_EQ(parameter_name_fault("C_d", UserLawKind::ForcePerLength), "");
    EXPECT_NE(parameter_name_fault("v", UserLawKind::ForcePerLength), "");
    EXPECT_EQ(parameter_name_fault("v", UserLawKind::BaseMoment), "");
    EXPECT_NE(parameter_name_fault("sin", UserLawKind::ForcePerLength), "");
    EXPECT_NE(parameter_name_fault("2c", UserLawKind::ForcePerLength), "");
}

} // namespace
} // namespace culm::physics
