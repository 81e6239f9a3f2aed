// SPDX-License-Identifier: BSD-3-Clause
// Least squares against certified and hand-worked numbers.
#include "core/error.hpp"
#include "reduce/linear_regression.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

namespace culm::reduce {
namespace {

std::vector<std::string> line_names() {
    return {"intercept", "x"};
}

Eigen::MatrixXd line_design(const std::vector<double>& x) {
    Eigen::MatrixXd design(static_cast<Eigen::Index>(x.size()), 2);
    for (std::size_t i = 0; i < x.size(); ++i)
        design.row(static_cast<Eigen::Index>(i)) << 1.0, x[i];
    return design;
}

std::string refusal(const Eigen::MatrixXd& design, const std::vector<double>& response,
                    const std::vector<std::string>& names) {
    try {
        (void)regress(design, response, names);
    } catch (const core::NumericalError& error) {
        EXPECT_EQ(error.kind(), core::FailureKind::FitFailed);
        return error.what();
    }
    return "no error";
}

/// Longley (1967), J. Am. Stat. Assoc. 62:819; columns y, x1 … x6.
constexpr std::array<std::array<double, 7>, 16> longley = {{
    {60323, 83.0, 234289, 2356, 1590, 107608, 1947},
    {61122, 88.5, 259426, 2325, 1456, 108632, 1948},
    {60171, 88.2, 258054, 3682, 1616, 109773, 1949},
    {61187, 89.5, 284599, 3351, 1650, 110929, 1950},
    {63221, 96.2, 328975, 2099, 3099, 112075, 1951},
    {63639, 98.1, 346999, 1932, 3594, 113270, 1952},
    {64989, 99.0, 365385, 1870, 3547, 115094, 1953},
    {63761, 100.0, 363112, 3578, 3350, 116219, 1954},
    {66019, 101.2, 397469, 2904, 3048, 117388, 1955},
    {67857, 104.6, 419180, 2822, 2857, 118734, 1956},
    {68169, 108.4, 442769, 2936, 2798, 120445, 1957},
    {66513, 110.8, 444546, 4681, 2637, 121950, 1958},
    {68655, 112.6, 482704, 3813, 2552, 123366, 1959},
    {69564, 114.2, 502601, 3931, 2514, 125368, 1960},
    {69331, 115.7, 518173, 4806, 2572, 127852, 1961},
    {70551, 116.9, 554894, 4007, 2827, 130081, 1962},
}};

TEST(LinearRegression, LongleysIllConditionedDataGiveTheCertifiedValues) {
    Eigen::MatrixXd design(16, 7);
    std::vector<double> response;
    for (std::size_t i = 0; i < longley.size(); ++i) {
        response.push_back(longley[i][0]);
        design(static_cast<Eigen::Index>(i), 0) = 1.0;
        for (std::size_t j = 1; j < 7; ++j)
            design(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) = longley[i][j];
    }
    const std::vector<std::string> names = {"1", "x1", "x2", "x3", "x4", "x5", "x6"};
    const LinearRegression found = regress(design, response, names);
    // Certified estimates and standard deviations of NIST's Statistical Reference Datasets.
    const std::array<std::array<double, 2>, 7> certified = {
        {{-3482258.63459582, 890420.383607373},
         {15.0618722713733, 84.9149257747669},
         {-0.358191792925910e-01, 0.334910077722432e-01},
         {-2.02022980381683, 0.488399681651699},
         {-1.03322686717359, 0.214274163161675},
         {-0.511041056535807e-01, 0.226073200069370},
         {1829.15146461355, 455.478499142212}}};
    // The scaled design has a condition of about 4e4: rounding grows to some 1e-11 relative.
    for (std::size_t j = 0; j < 7; ++j) {
        const Coefficient& c = found.coefficients[j];
        EXPECT_NEAR(c.value / certified[j][0], 1.0, 1e-9) << j;
        EXPECT_NEAR(c.standard_error / certified[j][1], 1.0, 1e-9) << j;
    }
    EXPECT_NEAR(found.sigma, 304.854073561965, 1e-7);
    EXPECT_NEAR(found.r_squared, 0.995479004577296, 1e-12);
    EXPECT_NEAR(found.adjusted_r_squared, 1.0 - (1.0 - 0.995479004577296) * 15.0 / 9.0, 1e-12);
    EXPECT_EQ(found.degrees_of_freedom, 9U);
}

TEST(LinearRegression, ALineMatchesTheHandWorkedExample) {
    // x = 1..4, y = 1, 2, 2, 4: Sxx = 5, Sxy = 4.5, Syy = 4.75; slope 0.9, intercept 0, RSS 0.7.
    const LinearRegression found =
        regress(line_design({1, 2, 3, 4}), std::vector<double>{1, 2, 2, 4}, line_names());
    constexpr double rounding = 1e-13;
    EXPECT_NEAR(found.coefficients[0].value, 0.0, rounding);
    EXPECT_NEAR(found.coefficients[1].value, 0.9, rounding);
    EXPECT_NEAR(found.residual_sum_of_squares, 0.7, rounding);
    EXPECT_NEAR(found.sigma, std::sqrt(0.35), rounding);
    EXPECT_NEAR(found.r_squared, 1.0 - 0.7 / 4.75, rounding);
    EXPECT_NEAR(found.adjusted_r_squared, 1.0 - 0.35 / (4.75 / 3.0), rounding);
    EXPECT_NEAR(found.coefficients[1].standard_error, std::sqrt(0.35 / 5.0), rounding);
    EXPECT_NEAR(found.coefficients[0].standard_error, std::sqrt(0.35 * (0.25 + 6.25 / 5.0)),
                rounding);
    // Student's t with two degrees of freedom in closed form.
    const double t = 0.9 / std::sqrt(0.07);
    EXPECT_NEAR(found.coefficients[1].p_value, 1.0 - t / std::sqrt(2.0 + t * t), 1e-12);
    const double factor = 0.95 / std::sqrt(2.0 * 0.975 * 0.025);
    EXPECT_NEAR(found.coefficients[1].lower, 0.9 - factor * std::sqrt(0.07), 1e-10);
    EXPECT_NEAR(found.coefficients[1].upper, 0.9 + factor * std::sqrt(0.07), 1e-10);
    const std::array<double, 4> residuals = {0.1, 0.2, -0.7, 0.4};
    for (std::size_t i = 0; i < 4; ++i)
        EXPECT_NEAR(found.residuals[i], residuals[i], rounding);
}

TEST(LinearRegression, APredictionMatchesTheTextbookFormula) {
    const LinearRegression line =
        regress(line_design({1, 2, 3, 4}), std::vector<double>{1, 2, 2, 4}, line_names());
    const Prediction at_six = predict(line, std::array{1.0, 6.0});
    // s² (1/n + (x − x̄)²/Sxx), and one s² more for a new observation.
    const double mean_variance = 0.35 * (0.25 + 3.5 * 3.5 / 5.0);
    EXPECT_NEAR(at_six.value, 5.4, 1e-12);
    EXPECT_NEAR(at_six.mean_standard_error, std::sqrt(mean_variance), 1e-12);
    EXPECT_NEAR(at_six.standard_error, std::sqrt(mean_variance + 0.35), 1e-12);
    EXPECT_NEAR(0.5 * (at_six.lower + at_six.upper), 5.4, 1e-12);
}

TEST(LinearRegression, MeasuresRSquaredAboutZeroWithoutAConstantColumn) {
    Eigen::MatrixXd design(3, 1);
    design << 1.0, 2.0, 3.0;
    const std::vector<std::string> names = {"x"};
    const LinearRegression found = regress(design, std::vector<double>{1.0, 2.0, 4.0}, names);
    // slope 17/14, RSS = 21 − 17²/14, total sum of squares 21 with three degrees of freedom.
    const double rss = 21.0 - 289.0 / 14.0;
    EXPECT_NEAR(found.r_squared, 1.0 - rss / 21.0, 1e-13);
    EXPECT_NEAR(found.adjusted_r_squared, 1.0 - (rss / 2.0) / 7.0, 1e-13);
}

TEST(LinearRegression, IntervalsCoverTheTruthIn95OutOf100Repeats) {
    std::mt19937_64 random(3);
    std::normal_distribution<double> noise(0.0, 0.5);
    int hits = 0;
    for (int repeat = 0; repeat < 400; ++repeat) {
        const std::vector<double> x = {0, 1, 2, 3, 4, 5, 6};
        std::vector<double> y(x.size());
        std::ranges::transform(x, y.begin(),
                               [&](double value) { return 2.0 - 0.7 * value + noise(random); });
        const Coefficient slope = regress(line_design(x), y, line_names()).coefficients[1];
        hits += slope.lower <= -0.7 && -0.7 <= slope.upper ? 1 : 0;
    }
    // Binomial(400, 0.95): 99.9 % lies between 363 and 394.
    EXPECT_GE(hits, 363);
    EXPECT_LE(hits, 394);
}

TEST(LinearRegression, AnExactLineHasNoScatter) {
    const LinearRegression found =
        regress(line_design({1, 2, 3, 4, 5}), std::vector<double>{3, 5, 7, 9, 11}, line_names());
    EXPECT_NEAR(found.coefficients[1].value, 2.0, 1e-13); // rounding
    EXPECT_LT(found.residual_sum_of_squares, found.rounding_sum_of_squares);
    EXPECT_NEAR(found.adjusted_r_squared, 1.0, 1e-13);
}

TEST(LinearRegression, DegenerateDesignsAreRefusedByName) {
    Eigen::MatrixXd design(5, 3);
    design << 1, 2, 4, 1, 3, 6, 1, 5, 10, 1, 7, 14, 1, 8, 16;
    const std::vector<double> y = {1, 2, 3, 4, 6};
    const std::vector<std::string> names = {"one", "length", "twice"};
    EXPECT_NE(refusal(design, y, names).find("depends linearly on the others"), std::string::npos);
    EXPECT_EQ(refusal(line_design({2, 2, 2, 2}), {1, 2, 3, 4}, line_names()).substr(0, 14),
              "the regressor ");
    EXPECT_EQ(refusal(line_design({0, 0, 0, 0}), {1, 2, 3, 4}, line_names()),
              "the regressor \"x\" is zero everywhere");
    EXPECT_EQ(refusal(line_design({1, 2}), {1, 2}, line_names()),
              "a regression with 2 coefficients needs at least 3 points, there are 2");
    const double nan = std::numeric_limits<double>::quiet_NaN();
    EXPECT_EQ(refusal(line_design({1, nan, 3}), {1, 2, 3}, line_names()),
              "the regressor \"x\" has a value that is not finite");
    EXPECT_EQ(refusal(line_design({1, 2, 3}), {1, nan, 3}, line_names()),
              "a response of the regression is not finite");
}

TEST(NestedFTest, MatchesTheHandWorkedExample) {
    const std::vector<double> y = {1, 2, 2, 4};
    const std::vector<std::string> mean_name = {"intercept"};
    const LinearRegression mean = regress(Eigen::MatrixXd::Ones(4, 1), y, mean_name);
    const LinearRegression line = regress(line_design({1, 2, 3, 4}), y, line_names());
    const NestedTest test = nested_f_test(mean, line);
    // RSS 4.75 against 0.70: F = (4.05/1)/(0.70/2); one degree in the numerator: F = t².
    const double f = 4.05 / 0.35;
    EXPECT_NEAR(test.f_statistic, f, 1e-11);
    EXPECT_NEAR(test.p_value, 1.0 - std::sqrt(f / (2.0 + f)), 1e-12);
    EXPECT_EQ(test.numerator_degrees_of_freedom, 1U);
    EXPECT_EQ(test.denominator_degrees_of_freedom, 2U);
    EXPECT_NEAR(test.p_value, line.coefficients[1].p_value, 1e-12);
}

} // namespace
} // namespace culm::reduce
