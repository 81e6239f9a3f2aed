// SPDX-License-Identifier: BSD-3-Clause
// The interaction model and its reduction by nested F-tests.
#include "reduce/study_regression.hpp"

#include <array>
#include <cmath>
#include <functional>
#include <random>

#include <gtest/gtest.h>

namespace culm::reduce {
namespace {

/// A full factorial of two predictors, like the paper's study.
struct Factorial {
    std::vector<double> first;
    std::vector<double> second;
    std::vector<double> response;
    [[nodiscard]] PredictorPair predictors() const { return {"b1", "b2", first, second}; }
};

Factorial make_factorial(const std::function<double(double, double)>& law, double noise,
                         std::uint64_t seed) {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> normal(0.0, 1.0);
    Factorial points;
    for (int i = 1; i <= 8; ++i) {
        for (int j = 1; j <= 10; ++j) {
            points.first.push_back(-0.1 * i);
            points.second.push_back(50.0 * std::sqrt(j));
            const double exact = law(points.first.back(), points.second.back());
            points.response.push_back(exact + noise * normal(random));
        }
    }
    return points;
}

std::vector<Term> all_four() {
    return {Term::Intercept, Term::First, Term::Second, Term::Interaction};
}

/// RSS of the least squares on the given terms, by the normal equations in long double and Gaussian
/// elimination. It shares no code with the implementation.
long double independent_rss(const Factorial& points, const std::vector<Term>& terms) {
    const std::size_t p = terms.size();
    std::vector<std::vector<long double>> a(p, std::vector<long double>(p + 1, 0.0L));
    const auto regressor = [&](std::size_t j, std::size_t i) -> long double {
        const long double x = points.first[i];
        const long double z = points.second[i];
        const std::array<long double, 4> values = {1.0L, x, z, x * z};
        return values[static_cast<std::size_t>(terms[j])];
    };
    for (std::size_t i = 0; i < points.response.size(); ++i)
        for (std::size_t r = 0; r < p; ++r) {
            for (std::size_t c = 0; c < p; ++c)
                a[r][c] += regressor(r, i) * regressor(c, i);
            a[r][p] += regressor(r, i) * points.response[i];
        }
    for (std::size_t k = 0; k < p; ++k)
        for (std::size_t r = 0; r < p; ++r) {
            if (r == k)
                continue;
            const long double factor = a[r][k] / a[k][k];
            for (std::size_t c = k; c <= p; ++c)
                a[r][c] -= factor * a[k][c];
        }
    long double rss = 0.0L;
    for (std::size_t i = 0; i < points.response.size(); ++i) {
        long double residual = points.response[i];
        for (std::size_t j = 0; j < p; ++j)
            residual -= a[j][p] / a[j][j] * regressor(j, i);
        rss += residual * residual;
    }
    return rss;
}

TEST(InteractionModel, EveryTestOfTheEliminationIsTheNestedFTest) {
    const Factorial points =
        make_factorial([](double, double b2) { return 91.4 + 574.3 * b2; }, 500.0, 4);
    const InteractionModel model = reduce_interaction_model(points.predictors(), points.response);
    std::vector<Term> current = all_four();
    std::vector<Term> next = all_four();
    ASSERT_GE(model.history.back().round, 2);
    for (std::size_t i = 0; i < model.history.size(); ++i) {
        const EliminationTest& step = model.history[i];
        if (i > 0 && step.round > model.history[i - 1].round)
            current = next;
        std::vector<Term> smaller = current;
        std::erase(smaller, step.term);
        const long double full = independent_rss(points, current);
        const long double reduced = independent_rss(points, smaller);
        const auto freedom = static_cast<long double>(80 - current.size());
        const auto f = static_cast<double>((reduced - full) / (full / freedom));
        // The normal equations square a condition of about 1e3: 1e-13 in long double; the
        // difference of two close RSS loses some six digits of the double's sixteen.
        EXPECT_NEAR(step.test.f_statistic, f, 1e-7 * std::max(f, 1.0)) << step.name;
        EXPECT_EQ(step.test.numerator_degrees_of_freedom, 1U);
        EXPECT_EQ(step.test.denominator_degrees_of_freedom, 80U - current.size());
        if (step.dropped)
            next = smaller;
    }
    EXPECT_EQ(next, model.terms);
}

TEST(InteractionModel, TermsWithoutInfluenceAreDropped) {
    const Factorial points =
        make_factorial([](double, double b2) { return 91.4 + 574.3 * b2; }, 500.0, 4);
    const InteractionModel model = reduce_interaction_model(points.predictors(), points.response);
    EXPECT_EQ(model.terms, (std::vector<Term>{Term::Intercept, Term::Second}));
    EXPECT_EQ(model.regression.coefficients[0].name, "intercept");
    EXPECT_EQ(model.regression.coefficients[1].name, "b2");
    EXPECT_EQ(model.history.front().name, "b1:b2");
    EXPECT_TRUE(model.history.front().dropped);
    EXPECT_FALSE(model.history.back().dropped);
    EXPECT_LT(model.history.back().test.p_value, 0.05);
}

TEST(InteractionModel, APredictorStaysWhileItsInteractionIsInTheModel) {
    // The predictors have no effect on average; only their product matters.
    const Factorial points =
        make_factorial([](double b1, double b2) { return 5.0 + 2.0 * b1 * b2; }, 0.5, 5);
    const InteractionModel model = reduce_interaction_model(points.predictors(), points.response);
    EXPECT_EQ(model.terms, all_four());
    ASSERT_EQ(model.history.size(), 1U); // only the interaction was tested
    EXPECT_EQ(model.history[0].term, Term::Interaction);
    EXPECT_FALSE(model.history[0].dropped);
    EXPECT_EQ(model.full_adjusted_r_squared, model.regression.adjusted_r_squared);
}

TEST(InteractionModel, BothPredictorsStayIfBothMatter) {
    const Factorial points =
        make_factorial([](double b1, double b2) { return 1.0 - 261.4 * b1 + 0.3 * b2; }, 2.0, 6);
    const InteractionModel model = reduce_interaction_model(points.predictors(), points.response);
    EXPECT_EQ(model.terms, (std::vector<Term>{Term::Intercept, Term::First, Term::Second}));
    ASSERT_EQ(model.history.size(), 3U);
}

TEST(InteractionModel, PureNoiseLeavesTheIntercept) {
    const Factorial points = make_factorial([](double, double) { return 3.0; }, 1.0, 8);
    const InteractionModel model = reduce_interaction_model(points.predictors(), points.response);
    EXPECT_EQ(model.terms, std::vector<Term>{Term::Intercept});
}

TEST(InteractionModel, ATrueNullIsRejectedAtTheNominalRate) {
    int rejected = 0;
    for (std::uint64_t seed = 0; seed < 400; ++seed) {
        const Factorial points =
            make_factorial([](double b1, double b2) { return b1 + b2; }, 1.0, 1000 + seed);
        const InteractionModel model =
            reduce_interaction_model(points.predictors(), points.response);
        rejected += model.history.front().dropped ? 0 : 1;
    }
    // Binomial(400, 0.05): 99.9 % lies between 6 and 37 (mean 20, standard deviation 4.36).
    EXPECT_GE(rejected, 6);
    EXPECT_LE(rejected, 37);
}

TEST(InteractionModel, RoundingIsNoEvidenceForATerm) {
    const Factorial points =
        make_factorial([](double, double b2) { return 91.4 + 574.3 * b2; }, 0.0, 1);
    const InteractionModel model = reduce_interaction_model(points.predictors(), points.response);
    EXPECT_EQ(model.terms, (std::vector<Term>{Term::Intercept, Term::Second}));
    EXPECT_NEAR(model.regression.coefficients[0].value, 91.4, 1e-7); // rounding of values near 1e5
    EXPECT_NEAR(model.regression.coefficients[1].value, 574.3, 1e-9);
}

TEST(InteractionModel, TheSignificanceDecides) {
    // The p-value of this weak effect is between the two significances.
    const Factorial points =
        make_factorial([](double b1, double b2) { return b2 + 4.0 * b1; }, 4.0, 11);
    const InteractionModel lenient =
        reduce_interaction_model(points.predictors(), points.response, 0.05);
    const InteractionModel strict =
        reduce_interaction_model(points.predictors(), points.response, 1e-6);
    EXPECT_EQ(lenient.terms, (std::vector<Term>{Term::Intercept, Term::First, Term::Second}));
    EXPECT_EQ(strict.terms, (std::vector<Term>{Term::Intercept, Term::Second}));
}

} // namespace
} // namespace culm::reduce
