// SPDX-License-Identifier: BSD-3-Clause
// Each law of the largest stable step is recovered from data that obey it.
#include "core/error.hpp"
#include "reduce/study_regression.hpp"

#include <cmath>
#include <functional>
#include <limits>

#include <gtest/gtest.h>

namespace culm::reduce {
namespace {

struct Stems {
    std::vector<double> moduli, dampings, bond_times, limits;

    [[nodiscard]] TimestepPoints view() const { return {moduli, dampings, bond_times, limits}; }
};

/// 3 moduli by 5 dampings, undamped stems included; τ = 1e-6 s at 1 GPa.
Stems stems_with(const std::function<double(double damping, double bond_time)>& limit) {
    Stems stems;
    for (const double modulus : {1e9, 3e9, 10e9})
        for (const double damping : {0.0, 0.5, 5.0, 50.0, 200.0}) {
            stems.moduli.push_back(modulus);
            stems.dampings.push_back(damping);
            stems.bond_times.push_back(1e-6 * std::sqrt(1e9 / modulus));
            stems.limits.push_back(limit(damping, stems.bond_times.back()));
        }
    return stems;
}

double oscillator_limit(double damping, double bond_time) {
    const double linear = 2.83 * damping;
    return 2.0 * bond_time / (linear + std::sqrt(linear * linear + 4.0 * 0.97));
}

TEST(TimestepRegression, RecoversTheDampedOscillator) {
    const Stems stems = stems_with(oscillator_limit);
    const TimestepRegression found = regress_timesteps(stems.view());
    ASSERT_TRUE(found.damped_oscillator.law);
    const TimestepLaw& law = *found.damped_oscillator.law;
    // Rounding: the regressors span four orders of magnitude.
    EXPECT_EQ(law.regression.coefficients[0].name, "A");
    EXPECT_NEAR(law.regression.coefficients[0].value, 0.97, 1e-9);
    EXPECT_NEAR(law.regression.coefficients[1].value, 2.83, 1e-9);
    EXPECT_LT(law.largest_residual, 1e-9);
    EXPECT_EQ(law.residuals.size(), 15U);
    EXPECT_EQ(found.points_used, 15U);
    // The form of the rule does not suit these data, which are curved near β = 0.
    ASSERT_TRUE(found.rule_form.law);
    EXPECT_GT(found.rule_form.law->largest_residual, 0.05);
}

TEST(TimestepRegression, RecoversTheFormOfTheAuthorsRule) {
    const Stems stems = stems_with(
        [](double damping, double bond_time) { return bond_time / (1.1 + 2.9 * damping); });
    const TimestepRegression found = regress_timesteps(stems.view());
    ASSERT_TRUE(found.rule_form.law);
    EXPECT_NEAR(found.rule_form.law->regression.coefficients[0].value, 1.1, 1e-9);
    EXPECT_NEAR(found.rule_form.law->regression.coefficients[1].value, 2.9, 1e-9);
    EXPECT_LT(found.rule_form.law->largest_residual, 1e-9);
}

TEST(TimestepRegression, LeavesOutWhatIsNoLimit) {
    Stems stems = stems_with(oscillator_limit);
    stems.limits[3] = std::numeric_limits<double>::quiet_NaN();
    stems.limits[7] = 0.0;
    const TimestepRegression found = regress_timesteps(stems.view());
    EXPECT_EQ(found.points_used, 13U);
    EXPECT_EQ(found.points_excluded, 2U);
    EXPECT_NEAR(found.damped_oscillator.law->regression.coefficients[1].value, 2.83, 1e-9);
}

TEST(TimestepRegression, SaysWhyThereIsNoLaw) {
    const std::vector<double> moduli{1e9, 2e9, 3e9};
    const std::vector<double> dampings{5.0, 5.0, 5.0};
    const std::vector<double> times{1e-6, 0.7e-6, 0.58e-6};
    const std::vector<double> limits{1e-7, 0.7e-7, 0.58e-7};
    // With a single β all stems differ only in the unit of time.
    const TimestepRegression found = regress_timesteps({moduli, dampings, times, limits});
    EXPECT_FALSE(found.rule_form.law);
    EXPECT_FALSE(found.rule_form.reason.empty());
    const TimestepRegression none = regress_timesteps({{}, {}, {}, {}});
    EXPECT_FALSE(none.damped_oscillator.law);
    EXPECT_FALSE(none.damped_oscillator.reason.empty());
    EXPECT_THROW((void)regress_timesteps({moduli, dampings, times, {}}), core::NumericalError);
}

} // namespace
} // namespace culm::reduce
