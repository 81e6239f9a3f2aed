// SPDX-License-Identifier: BSD-3-Clause
// Y and β from a stem's decay and frequency.
#include "core/error.hpp"
#include "reduce/study_regression.hpp"
#include "study_points.hpp"

#include <array>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

namespace culm::reduce {
namespace {

using testing::paper_study;
using testing::StudyData;

StemReading reading(double decay, double frequency) {
    return {normal_estimate(decay, 0.0), normal_estimate(frequency, 0.0)};
}

TEST(StemPrediction, TheWorkedExampleOfThePaperFollowsFromItsLaws) {
    const StudyRegression study = regress_study(paper_study(0.0, 0.0).view());
    const StemPrediction stem = predict_stem(study, reading(-0.64, 113.1));
    const double root = 574.3 * 113.1 + 91.4;  // 4.23 GPa in the paper
    const double damping = 261.4 * 0.64 + 2.5; // 169.8; the paper's 164.80 is a misprint
    // Rounding of the regression, relative.
    EXPECT_NEAR(stem.bond_youngs_modulus.by_single_law->value / (root * root), 1.0, 1e-10);
    EXPECT_NEAR(stem.bond_youngs_modulus.by_reduced_model->value / (root * root), 1.0, 1e-10);
    EXPECT_NEAR(stem.bond_damping.by_single_law->value, damping, 1e-8);
    EXPECT_NEAR(stem.bond_damping.by_reduced_model->value, damping, 1e-8);
    EXPECT_NEAR(stem.bond_youngs_modulus.by_single_law->value, 4.23e9, 0.01e9);
    EXPECT_TRUE(stem.is_inside_design);
    EXPECT_TRUE(stem.bond_damping.reason.empty());
}

TEST(StemPrediction, ErrorsOfTheSquareFollowTheDeltaMethod) {
    const StudyRegression study = regress_study(paper_study(300.0, 1.0).view());
    const LinearRegression& law = study.sqrt_youngs_modulus.regression->single.regression;
    const Prediction root = predict(law, std::array{1.0, 113.1});
    const Prediction modulus =
        *predict_stem(study, reading(-0.5, 113.1)).bond_youngs_modulus.by_single_law;
    constexpr double rounding = 1e-12;
    EXPECT_NEAR(modulus.value / (root.value * root.value), 1.0, rounding);
    EXPECT_NEAR(modulus.standard_error / (2.0 * root.value * root.standard_error), 1.0, rounding);
    EXPECT_NEAR(modulus.mean_standard_error / (2.0 * root.value * root.mean_standard_error), 1.0,
                rounding);
    EXPECT_NEAR(modulus.lower / (root.lower * root.lower), 1.0, rounding);
    EXPECT_NEAR(modulus.upper / (root.upper * root.upper), 1.0, rounding);
}

TEST(StemPrediction, TheReadingsOwnErrorsEnterThroughTheSlope) {
    const StudyRegression study = regress_study(paper_study(300.0, 1.0).view());
    StemReading stem = reading(-0.5, 113.1);
    const Prediction exact = *predict_stem(study, stem).bond_damping.by_single_law;
    stem.decay_per_cycle.standard_error = 0.02;
    stem.frequency.standard_error = 1.0; // the law of β does not depend on it
    const Prediction uncertain = *predict_stem(study, stem).bond_damping.by_single_law;
    const double slope = study.bond_damping.regression->single.slope.value;
    EXPECT_EQ(uncertain.value, exact.value);
    EXPECT_NEAR(uncertain.standard_error, std::hypot(exact.standard_error, 0.02 * slope), 1e-12);
    EXPECT_GT(uncertain.upper - uncertain.lower, exact.upper - exact.lower);
}

TEST(StemPrediction, AnInteractionTiltsTheSlopeOfTheReducedModel) {
    StudyData data;
    for (int i = 1; i <= 10; ++i)
        for (int j = 1; j <= 8; ++j) {
            const double b1 = -0.1 * j;
            const double b2 = 50.0 + 15.0 * i;
            data.add(1e9 * i, 2.0 - 250.0 * b1 + 0.1 * b2 - 0.5 * b1 * b2 + 0.01 * ((i * j) % 5),
                     b1, b2);
        }
    const StudyRegression study = regress_study(data.view());
    ASSERT_EQ(study.bond_damping.regression->reduced->model.terms.size(), 4U);
    StemReading stem = reading(-0.35, 100.0);
    const Prediction exact = *predict_stem(study, stem).bond_damping.by_reduced_model;
    stem.decay_per_cycle.standard_error = 1.0;
    const Prediction by_decay = *predict_stem(study, stem).bond_damping.by_reduced_model;
    // ∂β/∂b1 = −250 − 0.5 · 100; with a scatter of 0.04 the slope has an error below 0.1.
    EXPECT_NEAR(by_decay.standard_error, 300.0, 0.1);
    EXPECT_NEAR(exact.value, 2.0 + 87.5 + 10.0 + 17.5, 0.05);
    stem.decay_per_cycle.standard_error = 0.0;
    stem.frequency.standard_error = 10.0;
    const Prediction by_frequency = *predict_stem(study, stem).bond_damping.by_reduced_model;
    EXPECT_NEAR(by_frequency.standard_error, 10.0 * (0.1 + 0.5 * 0.35), 0.01);
}

TEST(StemPrediction, IntervalsCoverANewPointIn95OutOf100Repeats) {
    int hits = 0;
    std::mt19937_64 random(99);
    std::normal_distribution<double> normal(0.0, 1.0);
    for (std::uint64_t seed = 0; seed < 400; ++seed) {
        // Scatter in the response at given readings, as the regression assumes.
        StudyData data;
        for (int i = 1; i <= 12; ++i)
            data.add(1e9 * i, 2.5 + 26.14 * i + 3.0 * normal(random), -0.1 * i, 50.0 + i);
        const StudyRegression study = regress_study(data.view());
        const double truth = 2.5 + 26.14 * 5.5 + 3.0 * normal(random);
        const Prediction found =
            *predict_stem(study, reading(-0.55, 55.0)).bond_damping.by_single_law;
        hits += found.lower <= truth && truth <= found.upper ? 1 : 0;
    }
    // Binomial(400, 0.95): 99.9 % lies between 363 and 394.
    EXPECT_GE(hits, 363);
    EXPECT_LE(hits, 394);
}

TEST(StemPrediction, AReadingOutsideOfTheStudyIsMarked) {
    const StudyRegression study = regress_study(paper_study(0.0, 0.0).view());
    EXPECT_FALSE(predict_stem(study, reading(-0.5, 300.0)).is_inside_design);
    EXPECT_FALSE(predict_stem(study, reading(-2.0, 113.1)).is_inside_design);
    EXPECT_TRUE(predict_stem(study, reading(-0.5, 113.1)).is_inside_design);
}

TEST(StemPrediction, LawsThatTheStudyCouldNotGiveAreEmptyWithAReason) {
    StudyData data;
    for (int i = 1; i <= 10; ++i)
        data.add(1e9 * i, 50.0, -0.19, (std::sqrt(1e9 * i) - 91.4 + i % 3) / 574.3);
    const StudyRegression study = regress_study(data.view());
    const StemPrediction stem = predict_stem(study, reading(-0.19, 100.0));
    EXPECT_FALSE(stem.bond_damping.by_single_law);
    EXPECT_FALSE(stem.bond_damping.reason.empty());
    EXPECT_TRUE(stem.bond_youngs_modulus.by_single_law);
    EXPECT_FALSE(stem.bond_youngs_modulus.by_reduced_model);
    EXPECT_FALSE(stem.bond_youngs_modulus.reason.empty());
}

TEST(StemPrediction, ANegativeRootIsNoModulus) {
    const StudyRegression study = regress_study(paper_study(0.0, 0.0).view());
    const StemPrediction stem = predict_stem(study, reading(-0.5, -10.0));
    EXPECT_FALSE(stem.bond_youngs_modulus.by_single_law);
    EXPECT_NE(stem.bond_youngs_modulus.reason.find("square root"), std::string::npos);
    const double nan = std::numeric_limits<double>::quiet_NaN();
    EXPECT_THROW((void)predict_stem(study, reading(nan, 60.0)), core::NumericalError);
}

} // namespace
} // namespace culm::reduce
