// SPDX-License-Identifier: BSD-3-Clause
// Each law of the largest stable step is recovered from data that obey it.
#include "reduce/study_regression.hpp"

#include <cmath>
#include <functional>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

namespace culm::reduce {
namespace {

/// 3 moduli by 5 dampings, undamped stems included; τ = 1e-6 s at 1 GPa.
std::vector<TimestepPoint>
stems_with(const std::function<double(double damping, double bond_time)>& limit) {
    std::vector<TimestepPoint> stems;
    for (const double modulus : {1e9, 3e9, 10e9})
        for (const double damping : {0.0, 0.5, 5.0, 50.0, 200.0}) {
            const double bond_time = 1e-6 * std::sqrt(1e9 / modulus);
            stems.push_back({modulus, damping, bond_time, limit(damping, bond_time)});
        }
    return stems;
}

double oscillator_limit(double damping, double bond_time) {
    const double linear = 2.83 * damping;
    return 2.0 * bond_time / (linear + std::sqrt(linear * linear + 4.0 * 0.97));
}

TEST(TimestepRegression, RecoversTheDampedOscillator) {
    const std::vector<TimestepPoint> stems = stems_with(oscillator_limit);
    const TimestepRegression found = regress_timesteps(stems);
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
    const std::vector<TimestepPoint> stems = stems_with(
        [](double damping, double bond_time) { return bond_time / (1.1 + 2.9 * damping); });
    const TimestepRegression found = regress_timesteps(stems);
    ASSERT_TRUE(found.rule_form.law);
    EXPECT_NEAR(found.rule_form.law->regression.coefficients[0].value, 1.1, 1e-9);
    EXPECT_NEAR(found.rule_form.law->regression.coefficients[1].value, 2.9, 1e-9);
    EXPECT_LT(found.rule_form.law->largest_residual, 1e-9);
}

TEST(TimestepRegression, LeavesOutWhatIsNoLimit) {
    std::vector<TimestepPoint> stems = stems_with(oscillator_limit);
    stems[3].limit = std::numeric_limits<double>::quiet_NaN();
    stems[7].limit = 0.0;
    const TimestepRegression found = regress_timesteps(stems);
    EXPECT_EQ(found.points_used, 13U);
    EXPECT_EQ(found.points_excluded, 2U);
    EXPECT_NEAR(found.damped_oscillator.law->regression.coefficients[1].value, 2.83, 1e-9);
}

TEST(TimestepRegression, SaysWhyThereIsNoLaw) {
    const std::vector<TimestepPoint> stems{
        {1e9, 5.0, 1e-6, 1e-7}, {2e9, 5.0, 0.7e-6, 0.7e-7}, {3e9, 5.0, 0.58e-6, 0.58e-7}};
    // With a single β all stems differ only in the unit of time.
    const TimestepRegression found = regress_timesteps(stems);
    EXPECT_FALSE(found.rule_form.law);
    EXPECT_FALSE(found.rule_form.reason.empty());
    const TimestepRegression none = regress_timesteps({});
    EXPECT_FALSE(none.damped_oscillator.law);
    EXPECT_FALSE(none.damped_oscillator.reason.empty());
}

} // namespace
} // namespace culm::reduce
