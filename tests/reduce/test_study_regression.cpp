// SPDX-License-Identifier: BSD-3-Clause
// The regressions of a study: Eqs. 12 and 13, reduced models, residuals, degenerate designs.
#include "reduce/study_regression.hpp"
#include "study_points.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

namespace culm::reduce {
namespace {

using testing::paper_study;
using testing::StudyData;

TEST(StudyRegression, DataThatObeyTheLawsOfThePaperReturnTheirConstants) {
    const StudyData data = paper_study(0.0, 0.0);
    const StudyRegression study = regress_study(data.view());
    ASSERT_TRUE(study.sqrt_youngs_modulus.regression);
    ASSERT_TRUE(study.bond_damping.regression);
    const ResponseRegression& modulus = *study.sqrt_youngs_modulus.regression;
    const ResponseRegression& damping = *study.bond_damping.regression;
    // Rounding of √Y near 1e5, hence 1e-11 · 1e2 in the intercept.
    EXPECT_NEAR(modulus.single.slope.value, 574.3, 1e-9);
    EXPECT_NEAR(modulus.single.intercept.value, 91.4, 1e-7);
    EXPECT_NEAR(damping.single.slope.value, -261.4, 1e-9);
    EXPECT_NEAR(damping.single.intercept.value, 2.5, 1e-9);
    EXPECT_EQ(modulus.single.slope.name, "frequency");
    EXPECT_EQ(damping.single.slope.name, "decay_per_cycle");
    EXPECT_NEAR(modulus.single.regression.adjusted_r_squared, 1.0, 1e-12);
    EXPECT_EQ(modulus.points, 80U);
    EXPECT_EQ(study.points_used, 80U);
    EXPECT_EQ(study.points_excluded, 0U);
    ASSERT_TRUE(modulus.reduced);
    ASSERT_TRUE(damping.reduced);
    EXPECT_EQ(modulus.reduced->model.terms, (std::vector<Term>{Term::Intercept, Term::Second}));
    EXPECT_EQ(damping.reduced->model.terms, (std::vector<Term>{Term::Intercept, Term::First}));
    EXPECT_EQ(modulus.reduced->single_predictor_against_full.p_value, 1.0);
}

TEST(StudyRegression, AnInteractionThatIsThereIsKeptAndTheSingleLawRejected) {
    StudyData data;
    for (int i = 1; i <= 10; ++i)
        for (int j = 1; j <= 8; ++j) {
            const double b1 = -0.1 * j;
            const double b2 = 50.0 * std::sqrt(i) + 0.01 * ((i * 7 + j * 3) % 5);
            const double root = 91.4 + 574.3 * b2 + 20.0 * b1 * b2 + 3.0 * ((i + 2 * j) % 3 - 1);
            data.add(root * root, 25.0 * j + 0.1 * ((i * j) % 4), b1, b2);
        }
    const StudyRegression study = regress_study(data.view());
    const ReducedModel& reduced = *study.sqrt_youngs_modulus.regression->reduced;
    EXPECT_EQ(reduced.model.terms.size(), 4U);
    EXPECT_LT(reduced.single_predictor_against_full.p_value, 1e-6);
    EXPECT_EQ(reduced.single_predictor_against_full.numerator_degrees_of_freedom, 2U);
    EXPECT_EQ(reduced.single_predictor_against_full.denominator_degrees_of_freedom, 76U);
}

TEST(StudyRegression, ResidualsArePerCentOfTheLargestObservedValue) {
    const StudyData data = paper_study(300.0, 1.0);
    const StudyRegression study = regress_study(data.view());
    const SinglePredictorLaw& law = study.bond_damping.regression->single;
    std::vector<double> percent;
    for (std::size_t i = 0; i < 80; ++i) {
        const double fitted = law.intercept.value + law.slope.value * data.decay[i];
        percent.push_back(100.0 * (data.damping[i] - fitted) / 200.0); // largest β: 200
    }
    const auto [lowest, highest] = std::ranges::minmax(percent);
    EXPECT_NEAR(law.largest_residual, std::max(-lowest, highest), 1e-10); // rounding
}

TEST(StudyRegression, OneDampingInTheStudyLeavesTheModulusLaw) {
    StudyData data;
    for (int i = 1; i <= 10; ++i)
        data.add(1e9 * i, 50.0, -0.19 - 1e-4 * (i % 3),
                 (std::sqrt(1e9 * i) - 91.4 + 5.0 * (i % 4)) / 574.3);
    const StudyRegression study = regress_study(data.view());
    EXPECT_FALSE(study.bond_damping.regression);
    EXPECT_EQ(study.bond_damping.reason,
              "bond_damping has the one value 50 at every point of the study: no law for it is "
              "identifiable");
    ASSERT_TRUE(study.sqrt_youngs_modulus.regression);
    EXPECT_TRUE(study.sqrt_youngs_modulus.reason.empty());
    // Scatter of at most 15 √Pa over a range of 7e4 changes the slope by less than 1e-3.
    EXPECT_NEAR(study.sqrt_youngs_modulus.regression->single.slope.value, 574.3, 0.5);
}

TEST(StudyRegression, OneDecayInTheStudyLeavesNoReducedModel) {
    StudyData data;
    for (int i = 1; i <= 10; ++i)
        data.add(1e9 * i, 50.0, -0.19, (std::sqrt(1e9 * i) - 91.4 + i % 3) / 574.3);
    const StudyRegression study = regress_study(data.view());
    ASSERT_TRUE(study.sqrt_youngs_modulus.regression);
    EXPECT_FALSE(study.sqrt_youngs_modulus.regression->reduced);
    EXPECT_NE(study.sqrt_youngs_modulus.regression->no_reduced_reason.find("depends linearly"),
              std::string::npos);
}

TEST(StudyRegression, OneFrequencyLeavesNoModulusLaw) {
    StudyData data;
    for (int j = 1; j <= 8; ++j)
        data.add(1e9 * j, 25.0 * j, -0.1 * j, 60.0);
    const StudyRegression study = regress_study(data.view());
    EXPECT_FALSE(study.sqrt_youngs_modulus.regression);
    EXPECT_EQ(study.sqrt_youngs_modulus.reason,
              "frequency has the one value 60 at every point of the study: no law for "
              "sqrt(bond_youngs_modulus) is identifiable");
    EXPECT_TRUE(study.bond_damping.regression);
}

TEST(StudyRegression, FewerThanThreePointsGiveAReason) {
    StudyData data;
    EXPECT_NE(regress_study(data.view()).bond_damping.reason.find("there are 0"),
              std::string::npos);
    data.add(1e9, 25.0, -0.1, 55.0);
    data.add(2e9, 50.0, -0.2, 78.0);
    const StudyRegression study = regress_study(data.view());
    EXPECT_FALSE(study.sqrt_youngs_modulus.regression);
    EXPECT_EQ(study.bond_damping.reason,
              "bond_damping needs at least 3 usable points, there are 2");
}

TEST(StudyRegression, FourPointsGiveTheSingleLawButNoFullModel) {
    StudyData data;
    data.add(1e9, 25.0, -0.1, 55.0);
    data.add(2e9, 50.0, -0.2, 78.1);
    data.add(3e9, 75.0, -0.31, 95.0);
    data.add(4e9, 100.0, -0.4, 110.2);
    const StudyRegression study = regress_study(data.view());
    ASSERT_TRUE(study.bond_damping.regression);
    EXPECT_FALSE(study.bond_damping.regression->reduced);
    EXPECT_EQ(study.bond_damping.regression->no_reduced_reason,
              "a regression with 4 coefficients needs at least 5 points, there are 4");
}

TEST(StudyRegression, UnusablePointsAreExcludedAndCounted) {
    StudyData data = paper_study(300.0, 1.0);
    const StudyRegression clean = regress_study(data.view());
    const double nan = std::numeric_limits<double>::quiet_NaN();
    data.add(1e9, 25.0, nan, 55.0);
    data.add(1e9, 25.0, -0.1, std::numeric_limits<double>::infinity());
    data.add(-1e9, 25.0, -0.1, 55.0);
    data.add(1e9, nan, -0.1, 55.0);
    const StudyRegression study = regress_study(data.view());
    EXPECT_EQ(study.points_used, 80U);
    EXPECT_EQ(study.points_excluded, 4U);
    // The arithmetic and its inputs are the same.
    EXPECT_EQ(study.bond_damping.regression->single.slope.value,
              clean.bond_damping.regression->single.slope.value);
}

} // namespace
} // namespace culm::reduce
