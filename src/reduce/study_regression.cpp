// SPDX-License-Identifier: BSD-3-Clause
#include "reduce/study_regression.hpp"

#include "core/error.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

namespace culm::reduce {

namespace {

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

/// One response and what it is regressed on.
struct ResponseTask {
    std::string name;
    std::span<const double> values;
    Term predictor = Term::First;
};

UsablePoints usable_points(const StudyPoints& points) {
    const std::size_t n = points.bond_youngs_modulus.size();
    if (points.bond_damping.size() != n || points.decay_per_cycle.size() != n ||
        points.frequency.size() != n)
        throw core::NumericalError(
            core::FailureKind::FitFailed,
            fmt::format("the study has {} moduli, {} dampings, {} decays and {} frequencies", n,
                        points.bond_damping.size(), points.decay_per_cycle.size(),
                        points.frequency.size()));
    UsablePoints usable;
    for (std::size_t i = 0; i < n; ++i) {
        const double modulus = points.bond_youngs_modulus[i];
        if (!std::isfinite(modulus) || modulus <= 0.0 || !std::isfinite(points.bond_damping[i]) ||
            !std::isfinite(points.decay_per_cycle[i]) || !std::isfinite(points.frequency[i]))
            continue;
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

PredictorRange range_of(const std::vector<double>& values) {
    if (values.empty())
        return {};
    const auto [lowest, highest] = std::ranges::minmax(values);
    return {lowest, highest};
}

ResidualSummary summarise(const LinearRegression& regression, std::span<const double> observed) {
    double largest = 0.0;
    for (const double value : observed)
        largest = std::max(largest, std::abs(value));
    ResidualSummary summary;
    for (const double residual : regression.residuals)
        summary.percent.push_back(100.0 * residual / largest);
    summary.histogram = make_histogram(summary.percent);
    return summary;
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

ResponseRegression regress_response(const ResponseTask& task, const PredictorPair& predictors,
                                    double significance) {
    const std::array single_terms = {Term::Intercept, task.predictor};
    ResponseRegression result;
    result.points = task.values.size();
    result.single.predictor = task.predictor;
    result.single.regression = regress_on_terms(predictors, task.values, single_terms);
    result.single.intercept = result.single.regression.coefficients[0];
    result.single.slope = result.single.regression.coefficients[1];
    result.single.residuals = summarise(result.single.regression, task.values);
    try {
        ReducedModel reduced;
        reduced.model = reduce_interaction_model(predictors, task.values, significance);
        reduced.single_predictor_against_full =
            nested_f_test(result.single.regression, regress_full(predictors, task.values));
        reduced.residuals = summarise(reduced.model.regression, task.values);
        result.reduced = std::move(reduced);
    } catch (const core::NumericalError& error) {
        result.no_reduced_reason = error.what();
    }
    return result;
}

RegressionOutcome regress_if_possible(const ResponseTask& task, const PredictorPair& predictors,
                                      double significance) {
    RegressionOutcome outcome;
    outcome.reason = obstacle(task, predictors);
    if (outcome.reason.empty())
        outcome.regression = regress_response(task, predictors, significance);
    return outcome;
}

} // namespace

StudyRegression regress_study(const StudyPoints& points, double significance) {
    if (!(significance > 0.0 && significance < 1.0))
        throw core::NumericalError(
            core::FailureKind::FitFailed,
            fmt::format("the significance of the F-tests is {:g}, it must lie between 0 and 1",
                        significance));
    const UsablePoints usable = usable_points(points);
    const PredictorPair predictors{decay_predictor_name, frequency_predictor_name,
                                   usable.decay_per_cycle, usable.frequency};
    StudyRegression study;
    study.points_used = usable.frequency.size();
    study.points_excluded = points.frequency.size() - study.points_used;
    study.decay_per_cycle = range_of(usable.decay_per_cycle);
    study.frequency = range_of(usable.frequency);
    study.sqrt_youngs_modulus =
        regress_if_possible({"sqrt(bond_youngs_modulus)", usable.sqrt_youngs_modulus, Term::Second},
                            predictors, significance);
    study.bond_damping = regress_if_possible({"bond_damping", usable.bond_damping, Term::First},
                                             predictors, significance);
    return study;
}

} // namespace culm::reduce
