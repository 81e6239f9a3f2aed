// SPDX-License-Identifier: BSD-3-Clause
#include "fit/solve/uncertainty_budget.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include <Eigen/Core>

namespace culm::fit {
namespace {

/// The step of central differences over a standard uncertainty. Changes of Y and of an input
/// cancel, so the curvature within a whole uncertainty would be seen.
constexpr double part_of_error = 0.01;

/// (numbers, parameters) derivatives by every fitted parameter.
Eigen::MatrixXd gradients(const Fit& fit, Eigen::Index count, const CaseNumbers& numbers) {
    Eigen::MatrixXd slopes = Eigen::MatrixXd::Zero(count, std::ssize(fit.parameters));
    for (std::size_t p = 0; p < fit.parameters.size(); ++p) {
        const auto [value, error] =
            std::pair(fit.parameters[p].value, fit.parameters[p].standard_error);
        const double step = part_of_error * (std::isfinite(error) ? error : 0.01 * std::abs(value));
        StemModel below = fit.parts.front().model;
        StemModel above = below;
        below.set_value(p, value - step);
        above.set_value(p, value + step);
        if (step > 0.0)
            slopes.col(static_cast<Eigen::Index>(p)) =
                (numbers(computed_case(above)) - numbers(computed_case(below))) / (2.0 * step);
    }
    return slopes;
}

/// Variance of g = slopesᵀ θ by the whole covariance. An infinite one counts only if g depends on
/// it.
double variance_along(const Eigen::VectorXd& slopes, const Fit& fit) {
    const StemModel& model = fit.parts.front().model;
    Eigen::VectorXd by_coordinate = slopes;
    for (Eigen::Index p = 0; p < slopes.size(); ++p)
        by_coordinate(p) /= model.coordinate_slope(static_cast<std::size_t>(p));
    double variance = 0.0;
    for (Eigen::Index p = 0; p < slopes.size(); ++p)
        for (Eigen::Index q = 0; q < slopes.size(); ++q)
            if (const double weight = by_coordinate(p) * by_coordinate(q); weight != 0.0)
                variance += weight * fit.covariance(p, q);
    return variance;
}

/// (numbers) u ∂g/∂z.
Eigen::VectorXd change_by(const StatedInput& input, const run::CaseSpec& computed,
                          Eigen::Index count, const CaseNumbers& numbers) {
    if (input.acts != InputActs::OnChain || !input.access.set)
        return Eigen::VectorXd::Zero(count);
    const auto with_error = [&](double error) -> Eigen::VectorXd {
        run::CaseSpec changed = computed;
        input.access.set(changed, error);
        return numbers(changed);
    };
    const double step = part_of_error * input.standard_uncertainty;
    return (with_error(step) - with_error(-step)) / (2.0 * part_of_error);
}

} // namespace

double UncertaintyBudget::share(std::size_t input, std::size_t parameter) const {
    const BudgetInput& line = inputs[input];
    const double part = line.sensitivities[parameter] * line.input.standard_uncertainty;
    return std::pow(part / combined[parameter], 2);
}

double UncertaintyBudget::share_of_readings(std::size_t parameter) const {
    return std::isfinite(combined[parameter])
               ? std::pow(from_readings[parameter] / combined[parameter], 2)
               : 1.0;
}

UncertaintyBudget uncertainty_budget(const Fit& fit, const measure::Measurement& measurement) {
    UncertaintyBudget budget;
    const std::size_t count = fit.parameters.size();
    std::vector<double> of_readings;
    for (const FittedParameter& parameter : fit.parameters) {
        budget.combined.push_back(parameter.standard_error);
        of_readings.push_back(std::pow(parameter.standard_error, 2));
    }
    std::vector<StatedInput> inputs = stated_inputs(measurement);
    std::size_t next = 0; // the terms of the inputs are in their order
    for (const Pull& pull : fit.pulls) {
        // Errors of single rows are listed with the noise of the readings.
        if (is_of_row(pull.kind))
            continue;
        const bool is_stated = pull.kind == ErrorKind::StatedInput;
        BudgetInput& line = budget.inputs.emplace_back();
        if (is_stated) {
            line.input = std::move(inputs[next++]);
        } else { // a number that the model adds
            line.input.name = pull.id;
            line.input.unit = "1";
            line.input.standard_uncertainty = 1.0;
        }
        line.pull = pull.value;
        line.uncertainty_with_readings = pull.standard_error * line.input.standard_uncertainty;
        for (std::size_t p = 0; p < count; ++p) {
            // If the stated value is larger by u, the same readings give a parameter that is
            // smaller by the change.
            const double change = pull.changes[p];
            line.sensitivities.push_back(-change / line.input.standard_uncertainty);
            of_readings[p] -= change * change;
        }
    }
    for (const double variance : of_readings)
        budget.from_readings.push_back(std::sqrt(std::max(variance, 0.0)));
    return budget;
}

Eigen::VectorXd uncertainties_of(const Fit& fit, const UncertaintyBudget& budget,
                                 const CaseNumbers& numbers) {
    const run::CaseSpec computed = computed_case(fit.parts.front().model);
    const Eigen::Index count = numbers(computed).size();
    const Eigen::MatrixXd slopes = gradients(fit, count, numbers);
    Eigen::ArrayXd variances(count);
    for (Eigen::Index k = 0; k < count; ++k)
        variances(k) = variance_along(slopes.row(k), fit);
    for (const BudgetInput& line : budget.inputs) {
        const Eigen::Map<const Eigen::VectorXd> sensitivities(line.sensitivities.data(),
                                                              slopes.cols());
        const Eigen::ArrayXd by_fit = line.input.standard_uncertainty * (slopes * sensitivities);
        // The covariance contains the first of the two changes alone.
        const Eigen::ArrayXd changes =
            by_fit + change_by(line.input, computed, count, numbers).array();
        variances += changes.square() - by_fit.square();
    }
    return variances.max(0.0).sqrt();
}

} // namespace culm::fit
