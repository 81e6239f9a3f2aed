// SPDX-License-Identifier: BSD-3-Clause
#include "reduce/study_regression.hpp"

#include "core/error.hpp"
#include "core/order_statistics.hpp"
#include "reduce/distributions.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include <fmt/format.h>

namespace culm::reduce {

namespace {

constexpr std::array all_terms = {Term::Intercept, Term::First, Term::Second, Term::Interaction};

std::vector<Term> without(const std::vector<Term>& terms, Term dropped) {
    std::vector<Term> rest;
    std::ranges::copy_if(terms, std::back_inserter(rest), [&](Term t) { return t != dropped; });
    return rest;
}

/// The terms that no other term of the model needs.
std::vector<Term> droppable(const std::vector<Term>& terms) {
    if (std::ranges::find(terms, Term::Interaction) != terms.end())
        return {Term::Interaction};
    return without(terms, Term::Intercept);
}

/// "intercept", a predictor's name, or both names joined by ':'.
std::string term_name(Term term, const PredictorPair& predictors) {
    const std::array<std::string, 4> names = {"intercept", predictors.first_name,
                                              predictors.second_name,
                                              predictors.first_name + ":" + predictors.second_name};
    return names[static_cast<std::size_t>(term)];
}

/// The regressor of a term at one point.
double term_value(Term term, double first, double second) {
    const std::array values = {1.0, first, second, first * second};
    return values[static_cast<std::size_t>(term)];
}

/// Least squares of the response on the given terms. Errors as of `regress`.
LinearRegression regress_on_terms(const PredictorPair& predictors, std::span<const double> response,
                                  std::span<const Term> terms) {
    Eigen::MatrixXd design(static_cast<Eigen::Index>(response.size()),
                           static_cast<Eigen::Index>(terms.size()));
    std::vector<std::string> names;
    for (std::size_t j = 0; j < terms.size(); ++j) {
        names.push_back(term_name(terms[j], predictors));
        for (std::size_t i = 0; i < response.size(); ++i)
            design(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) =
                term_value(terms[j], predictors.first[i], predictors.second[i]);
    }
    return regress(std::move(design), response, names);
}

constexpr std::size_t fewest_points = 3;
// Values that differ by less than this share of the largest are one value.
constexpr double same_value = 1e-10;

/// The points that can be used, column by column.
struct UsablePoints {
    std::vector<double> sqrt_youngs_modulus; // √Pa
    std::vector<double> bond_damping;
    std::vector<double> decay_per_cycle;
    std::vector<double> frequency; // Hz
};

/// One response and its predictors.
struct ResponseTask {
    std::string name;
    std::span<const double> values;
    Term predictor = Term::First;
};

UsablePoints usable_points(const StudyPoints& points) {
    UsablePoints usable;
    for (std::size_t i = 0; i < points.bond_youngs_modulus.size(); ++i) {
        const double modulus = points.bond_youngs_modulus[i];
        if (!std::isfinite(modulus) || modulus <= 0.0 || !std::isfinite(points.bond_damping[i]) ||
            !std::isfinite(points.decay_per_cycle[i]) || !std::isfinite(points.frequency[i]))
            continue;
        // The frequency of a linear elastic chain is proportional to √Y: the law is linear in √Y.
        usable.sqrt_youngs_modulus.push_back(std::sqrt(modulus));
        usable.bond_damping.push_back(points.bond_damping[i]);
        usable.decay_per_cycle.push_back(points.decay_per_cycle[i]);
        usable.frequency.push_back(points.frequency[i]);
    }
    return usable;
}

bool is_one_value(std::span<const double> values) {
    const auto [lowest, highest] = std::ranges::minmax(values);
    return highest - lowest <= same_value * std::max(std::abs(lowest), std::abs(highest));
}

/// The largest residual in per cent of the largest observed value. Takes the residuals out of the
/// regression: there may be millions.
double take_largest_residual(LinearRegression& regression, std::span<const double> observed) {
    const auto largest_of = [](std::span<const double> values) {
        const auto [lowest, highest] = std::ranges::minmax(values);
        return std::max(std::abs(lowest), std::abs(highest));
    };
    return 100.0 * largest_of(std::exchange(regression.residuals, {})) / largest_of(observed);
}

/// Empty if the single-predictor law is identifiable, else the reason.
std::string obstacle(const ResponseTask& task, const PredictorPair& predictors) {
    if (task.values.size() < fewest_points)
        return fmt::format("{} needs at least {} usable points, there are {}", task.name,
                           fewest_points, task.values.size());
    if (is_one_value(task.values))
        return fmt::format("{} has the one value {:g} at every point of the study: no law for it "
                           "is identifiable",
                           task.name, task.values.front());
    const auto predictor = task.predictor == Term::First ? predictors.first : predictors.second;
    if (is_one_value(predictor))
        return fmt::format("{} has the one value {:g} at every point of the study: no law for {} "
                           "is identifiable",
                           term_name(task.predictor, predictors), predictor.front(), task.name);
    return {};
}

RegressionOutcome regress_response(const ResponseTask& task, const PredictorPair& predictors,
                                   double significance) {
    RegressionOutcome outcome;
    outcome.reason = obstacle(task, predictors);
    if (!outcome.reason.empty())
        return outcome;
    const std::array single_terms = {Term::Intercept, task.predictor};
    ResponseRegression& result = outcome.regression.emplace();
    result.points = task.values.size();
    result.single.predictor = task.predictor;
    result.single.regression = regress_on_terms(predictors, task.values, single_terms);
    result.single.intercept = result.single.regression.coefficients[0];
    result.single.slope = result.single.regression.coefficients[1];
    result.single.largest_residual = take_largest_residual(result.single.regression, task.values);
    try {
        ReducedModel reduced;
        reduced.model = reduce_interaction_model(predictors, task.values, significance);
        reduced.single_predictor_against_full = nested_f_test(
            result.single.regression, regress_on_terms(predictors, task.values, all_terms));
        reduced.model.regression.residuals = std::vector<double>(); // frees the memory
        result.reduced = std::move(reduced);
    } catch (const core::NumericalError& error) {
        result.no_reduced_reason = error.what();
    }
    return outcome;
}

/// The law's slope along a predictor at the reading.
double slope_along(Term along, const LinearRegression& law, std::span<const Term> terms,
                   const StemReading& reading) {
    double slope = 0.0;
    for (std::size_t j = 0; j < terms.size(); ++j) {
        if (terms[j] == along)
            slope += law.coefficients[j].value;
        if (terms[j] == Term::Interaction)
            slope +=
                law.coefficients[j].value *
                (along == Term::First ? reading.frequency.value : reading.decay_per_cycle.value);
    }
    return slope;
}

Prediction predict_response(const LinearRegression& law, std::span<const Term> terms,
                            const StemReading& reading) {
    std::vector<double> regressors;
    for (const Term term : terms)
        regressors.push_back(
            term_value(term, reading.decay_per_cycle.value, reading.frequency.value));
    const Prediction exact = predict(law, regressors);
    // The errors of b1 and b2 propagate through the law to first order. They are independent of the
    // law's errors and of each other.
    const double reading_error = std::hypot(
        slope_along(Term::First, law, terms, reading) * reading.decay_per_cycle.standard_error,
        slope_along(Term::Second, law, terms, reading) * reading.frequency.standard_error);
    const double variance = std::pow(exact.standard_error, 2) + std::pow(reading_error, 2);
    return {estimate(exact.value, variance, student_t_factor(law.degrees_of_freedom)),
            std::hypot(exact.mean_standard_error, reading_error)};
}

ParameterPrediction predict_parameter(const RegressionOutcome& outcome,
                                      const StemReading& reading) {
    ParameterPrediction result;
    if (!outcome.regression) {
        result.reason = outcome.reason;
        return result;
    }
    const SinglePredictorLaw& single = outcome.regression->single;
    const std::array single_terms = {Term::Intercept, single.predictor};
    result.by_single_law = predict_response(single.regression, single_terms, reading);
    if (outcome.regression->reduced) {
        const InteractionModel& model = outcome.regression->reduced->model;
        result.by_reduced_model = predict_response(model.regression, model.terms, reading);
    } else {
        result.reason = outcome.regression->no_reduced_reason;
    }
    return result;
}

/// From √Y to Y; empty, with a reason, where the root is not positive.
void square(std::optional<Prediction>& prediction, std::string& reason) {
    if (!prediction)
        return;
    if (prediction->value <= 0.0) {
        reason = fmt::format("the law gives a square root of Young's modulus of {:g}: the reading "
                             "lies far outside of the study",
                             prediction->value);
        prediction.reset();
        return;
    }
    // dY = 2 √Y d(√Y) for the errors; the ends of the interval are squared, which keeps their
    // coverage.
    const double root = prediction->value;
    const double lower = std::max(prediction->lower, 0.0);
    prediction = Prediction{{root * root, 2.0 * root * prediction->standard_error, lower * lower,
                             prediction->upper * prediction->upper},
                            2.0 * root * prediction->mean_standard_error};
}

/// u = τ/Δt.
double inverse_step(const TimestepPoint& point) {
    return point.bond_time / point.limit;
}

bool is_usable(const TimestepPoint& point) {
    return std::isfinite(point.bond_damping) && point.bond_damping >= 0.0 &&
           std::isfinite(point.bond_youngs_modulus) && point.bond_youngs_modulus > 0.0 &&
           point.limit > 0.0 && std::isfinite(inverse_step(point)) && inverse_step(point) > 0.0;
}

/// `row(point)` gives the regressors and, last, the right-hand side; `fitted(coefficients, point)`
/// the step of the law.
template <std::size_t N, class Row, class Fitted>
TimestepLawOutcome fit_law(std::span<const TimestepPoint> points,
                           const std::array<std::string, N>& names, const Row& row,
                           const Fitted& fitted) {
    Eigen::MatrixXd design(static_cast<Eigen::Index>(points.size()), static_cast<Eigen::Index>(N));
    std::vector<double> responses;
    for (std::size_t k = 0; k < points.size(); ++k) {
        const std::array<double, N + 1> numbers = row(points[k]);
        for (std::size_t c = 0; c < N; ++c)
            design(static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(c)) = numbers[c];
        responses.push_back(numbers.back());
    }
    TimestepLawOutcome outcome;
    try {
        TimestepLaw law{regress(std::move(design), responses, names), {}, 0.0};
        for (const TimestepPoint& point : points) {
            law.residuals.push_back(point.limit / fitted(law.regression.coefficients, point) - 1.0);
            law.largest_residual = std::max(law.largest_residual, std::abs(law.residuals.back()));
        }
        outcome.law = std::move(law);
    } catch (const core::NumericalError& error) {
        outcome.reason = error.what();
    }
    return outcome;
}

using Coefficients = std::vector<Coefficient>;

/// (τ/dt)² = A + B β (τ/dt), the limit of central differences for a damped oscillator, divided by
/// u² = (τ/dt)² so that every stem's error counts relative to its step: 1 = A/u² + B β/u.
TimestepLawOutcome fit_damped_oscillator(std::span<const TimestepPoint> points) {
    return fit_law<2>(
        points, {"A", "B"},
        [](const TimestepPoint& p) {
            const double u = inverse_step(p);
            return std::array{1.0 / (u * u), p.bond_damping / u, 1.0};
        },
        [](const Coefficients& c, const TimestepPoint& p) {
            const double linear = c[1].value * p.bond_damping;
            const double u = 0.5 * (linear + std::sqrt(linear * linear + 4.0 * c[0].value));
            return p.limit * inverse_step(p) / u;
        });
}

/// dt = τ/(a + b β), the form of the authors' rule, as 1 = a/u + b β/u.
TimestepLawOutcome fit_rule_form(std::span<const TimestepPoint> points) {
    return fit_law<2>(
        points, {"a", "b"},
        [](const TimestepPoint& p) {
            const double u = inverse_step(p);
            return std::array{1.0 / u, p.bond_damping / u, 1.0};
        },
        [](const Coefficients& c, const TimestepPoint& p) {
            return p.limit * inverse_step(p) / (c[0].value + c[1].value * p.bond_damping);
        });
}

} // namespace

InteractionModel reduce_interaction_model(const PredictorPair& predictors,
                                          std::span<const double> response, double significance) {
    InteractionModel model;
    model.terms.assign(all_terms.begin(), all_terms.end());
    model.regression = regress_on_terms(predictors, response, all_terms);
    model.full_adjusted_r_squared = model.regression.adjusted_r_squared;
    for (int round = 0; model.terms.size() > 1; ++round) {
        std::optional<std::size_t> weakest;
        LinearRegression without_weakest;
        for (const Term term : droppable(model.terms)) {
            LinearRegression reduced =
                regress_on_terms(predictors, response, without(model.terms, term));
            const NestedTest test = nested_f_test(reduced, model.regression);
            model.history.push_back({term, term_name(term, predictors), test, round, false});
            if (!weakest || test.p_value > model.history[*weakest].test.p_value) {
                weakest = model.history.size() - 1;
                without_weakest = std::move(reduced);
            }
        }
        EliminationTest& candidate = model.history[*weakest];
        if (candidate.test.p_value < significance)
            break;
        candidate.dropped = true;
        model.terms = without(model.terms, candidate.term);
        model.regression = std::move(without_weakest);
    }
    return model;
}

StudyRegression regress_study(const StudyPoints& points, double significance) {
    const UsablePoints usable = usable_points(points);
    const PredictorPair predictors{"decay_per_cycle", "frequency", usable.decay_per_cycle,
                                   usable.frequency};
    StudyRegression study;
    study.points_used = usable.frequency.size();
    study.points_excluded = points.frequency.size() - study.points_used;
    study.decay_per_cycle = core::range_of(usable.decay_per_cycle);
    study.frequency = core::range_of(usable.frequency);
    study.sqrt_youngs_modulus =
        regress_response({"sqrt(bond_youngs_modulus)", usable.sqrt_youngs_modulus, Term::Second},
                         predictors, significance);
    study.bond_damping = regress_response({"bond_damping", usable.bond_damping, Term::First},
                                          predictors, significance);
    return study;
}

StemPrediction predict_stem(const StudyRegression& study, const StemReading& reading) {
    for (const double number :
         {reading.decay_per_cycle.value, reading.frequency.value,
          reading.decay_per_cycle.standard_error, reading.frequency.standard_error})
        if (!std::isfinite(number))
            throw core::NumericalError(
                core::FailureKind::FitFailed,
                fmt::format("the stem's reading (decay per cycle {:g}, frequency {:g} Hz) or its "
                            "standard errors are not finite",
                            reading.decay_per_cycle.value, reading.frequency.value));
    StemPrediction prediction;
    prediction.bond_youngs_modulus = predict_parameter(study.sqrt_youngs_modulus, reading);
    square(prediction.bond_youngs_modulus.by_single_law, prediction.bond_youngs_modulus.reason);
    square(prediction.bond_youngs_modulus.by_reduced_model, prediction.bond_youngs_modulus.reason);
    prediction.bond_damping = predict_parameter(study.bond_damping, reading);
    prediction.is_inside_design = study.decay_per_cycle.contains(reading.decay_per_cycle.value) &&
                                  study.frequency.contains(reading.frequency.value);
    return prediction;
}

TimestepRegression regress_timesteps(std::span<const TimestepPoint> points) {
    std::vector<TimestepPoint> usable;
    std::ranges::copy_if(points, std::back_inserter(usable), is_usable);
    TimestepRegression regression;
    regression.points_used = usable.size();
    regression.points_excluded = points.size() - usable.size();
    regression.damped_oscillator = fit_damped_oscillator(usable);
    regression.rule_form = fit_rule_form(usable);
    return regression;
}

} // namespace culm::reduce
