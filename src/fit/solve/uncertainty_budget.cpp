// SPDX-License-Identifier: BSD-3-Clause
#include "fit/solve/uncertainty_budget.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Cholesky>
#include <Eigen/Core>

namespace culm::fit {
namespace {

/// Derivatives of the readings that were seen, over their noise.
struct WeightedDerivatives {
    Eigen::MatrixXd by_parameters; ///< (readings, parameters), of the prediction
    Eigen::MatrixXd by_inputs;     ///< (readings, inputs), of measured − predicted
    Eigen::VectorXd residuals;     ///< (readings), measured − predicted
};

/// The fitted model with the inputs as its parameters, so that one run gives all derivatives.
ChainPrediction by_inputs(const RecordingFit& fit, const std::vector<StatedInput>& inputs,
                          const run::Heartbeat& heartbeat) {
    StemModel model = fit.model;
    model.parameters.clear();
    for (const StatedInput& input : inputs)
        if (!input.scales_times)
            model.parameters.push_back({input.access, input.unit});
    return predict_readings(model, fit.times, heartbeat);
}

double finite(double derivative) {
    return std::isfinite(derivative) ? derivative : 0.0;
}

WeightedDerivatives weighted_derivatives(const RecordingFit& fit,
                                         const std::vector<StatedInput>& inputs,
                                         const run::Heartbeat& heartbeat) {
    const ChainPrediction changed = by_inputs(fit, inputs, heartbeat);
    const std::size_t parameters = fit.prediction.parameters;
    const auto seen = static_cast<Eigen::Index>(
        std::ranges::count_if(fit.residuals, [](double each) { return !std::isnan(each); }));
    WeightedDerivatives out{Eigen::MatrixXd(seen, static_cast<Eigen::Index>(parameters)),
                            Eigen::MatrixXd(seen, static_cast<Eigen::Index>(inputs.size())),
                            Eigen::VectorXd(seen)};
    Eigen::Index row = 0;
    for (std::size_t place = 0; place < fit.residuals.size(); ++place) {
        if (std::isnan(fit.residuals[place]))
            continue;
        const double weight = 1.0 / fit.noise[place % fit.prediction.rows];
        const double* const jacobian = fit.prediction.jacobian.data() + place * parameters;
        for (std::size_t k = 0; k < parameters; ++k)
            out.by_parameters(row, static_cast<Eigen::Index>(k)) = weight * finite(jacobian[k]);
        const double* next = changed.jacobian.data() + place * changed.parameters;
        for (std::size_t k = 0; k < inputs.size(); ++k) {
            double derivative = 0.0;
            if (inputs[k].scales_times) {
                // With a rate that is larger by the share c the reading was taken at t/(1 + c), and
                // the prediction there is smaller by c t dy/dt. The last derivative is −dy/dt.
                const double time = fit.times[place / fit.prediction.rows];
                derivative = fit.model.release_time_bound > 0.0
                                 ? -time * finite(jacobian[parameters - 1])
                                 : 0.0;
            } else {
                derivative = -finite(*next++);
                if (inputs[k].scales_readings)
                    derivative += fit.prediction.readings[place];
            }
            out.by_inputs(row, static_cast<Eigen::Index>(k)) = weight * derivative;
        }
        out.residuals(row++) = weight * fit.residuals[place];
    }
    return out;
}

/// Pulls, and what statement and readings together leave uncertain. The parameters follow the
/// inputs: only what they cannot take up of an input's derivative tells of it.
void add_pulls(const WeightedDerivatives& of, const Eigen::MatrixXd& sensitivities,
               double misfit_factor, UncertaintyBudget& budget) {
    const Eigen::MatrixXd standing_out = of.by_inputs - of.by_parameters * sensitivities;
    // A misfit that is not noise must not count as knowledge: readings weigh less by the reduced
    // χ².
    Eigen::MatrixXd information = standing_out.transpose() * standing_out / misfit_factor;
    const Eigen::VectorXd slope = standing_out.transpose() * of.residuals / misfit_factor;
    // In units of u the statement's own information is 1.
    Eigen::VectorXd u(static_cast<Eigen::Index>(budget.inputs.size()));
    for (Eigen::Index k = 0; k < u.size(); ++k)
        u(k) = budget.inputs[static_cast<std::size_t>(k)].input.standard_uncertainty;
    information = u.asDiagonal() * information * u.asDiagonal();
    information.diagonal().array() += 1.0;
    const Eigen::LLT<Eigen::MatrixXd> solver(information);
    const Eigen::VectorXd pulls = -solver.solve(u.cwiseProduct(slope));
    const Eigen::MatrixXd covariance = solver.solve(Eigen::MatrixXd::Identity(u.size(), u.size()));
    for (Eigen::Index k = 0; k < u.size(); ++k) {
        BudgetInput& input = budget.inputs[static_cast<std::size_t>(k)];
        input.pull = pulls(k);
        input.uncertainty_with_readings = u(k) * std::sqrt(covariance(k, k));
    }
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

UncertaintyBudget uncertainty_budget(const RecordingFit& fit,
                                     const measure::Measurement& measurement,
                                     const run::Heartbeat& heartbeat) {
    const std::vector<StatedInput> inputs = stated_inputs(measurement);
    const WeightedDerivatives of = weighted_derivatives(fit, inputs, heartbeat);
    // The fit's covariance is (JᵀWJ)⁻¹ times this factor (RecordingFit). What the readings do not
    // tell does not follow an input.
    const double factor = std::max(1.0, fit.reduced_chi_squared);
    const Eigen::MatrixXd covariance = fit.covariance.unaryExpr(&finite);
    // Minimise |r + R dx − J dθ|²: dθ/dx = (JᵀJ)⁻¹ JᵀR.
    const Eigen::MatrixXd sensitivities =
        covariance / factor * (of.by_parameters.transpose() * of.by_inputs);
    UncertaintyBudget budget;
    for (std::size_t k = 0; k < inputs.size(); ++k) {
        const Eigen::VectorXd column = sensitivities.col(static_cast<Eigen::Index>(k));
        budget.inputs.push_back({inputs[k], {column.begin(), column.end()}});
    }
    add_pulls(of, sensitivities, factor, budget);
    for (std::size_t p = 0; p < fit.parameters.size(); ++p) {
        budget.from_readings.push_back(fit.parameters[p].standard_error);
        double variance = std::pow(budget.from_readings.back(), 2);
        for (const BudgetInput& line : budget.inputs)
            variance += std::pow(line.sensitivities[p] * line.input.standard_uncertainty, 2);
        budget.combined.push_back(std::sqrt(variance));
    }
    return budget;
}

} // namespace culm::fit
