// SPDX-License-Identifier: BSD-3-Clause
#include "fit/solve/uncertainty_budget.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace culm::fit {
namespace {

/// What the term of the fit stands for: a stated input, or a number of the model's own.
StatedInput input_of(const measure::ReadingErrors::Term& term, std::vector<StatedInput>& inputs,
                     std::size_t k) {
    if (k < inputs.size())
        return std::move(inputs[k]);
    StatedInput own;
    own.name = term.name;
    own.unit = "1";
    own.standard_uncertainty = 1.0;
    return own;
}

/// Of ln Y or ln β in case_beside_errors().
double relative_uncertainty(const RecordingFit& fit, const physics::ParameterId& id,
                            double measure::ReadingErrors::Term::*change) {
    Eigen::VectorXd gradient =
        Eigen::VectorXd::Zero(static_cast<Eigen::Index>(fit.model.free_count()));
    for (std::size_t p = 0; p < fit.model.parameters.size(); ++p)
        if (fit.model.parameters[p].access.id == id)
            gradient(static_cast<Eigen::Index>(p)) = 1.0 / fit.model.value(p);
    for (std::size_t k = 0; k < fit.model.error_values.size(); ++k)
        gradient(static_cast<Eigen::Index>(fit.model.first_error() + k)) =
            fit.model.errors->terms[k].*change;
    return std::sqrt(std::max(0.0, gradient.dot(fit.covariance * gradient)));
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
                                     const measure::Measurement& measurement) {
    UncertaintyBudget budget;
    const std::size_t first = fit.model.first_error();
    for (std::size_t p = 0; p < first; ++p) {
        budget.combined.push_back(fit.parameters[p].standard_error);
        budget.from_readings.push_back(std::pow(fit.parameters[p].standard_error, 2));
    }
    std::vector<StatedInput> inputs = stated_inputs(measurement);
    for (std::size_t k = 0; k < fit.model.error_values.size(); ++k) {
        const measure::ReadingErrors::Term& term = fit.model.errors->terms[k];
        if (term.is_of_row)
            continue; // the rows' errors stand with those of the readings
        BudgetInput& line = budget.inputs.emplace_back();
        line.input = input_of(term, inputs, k);
        const FittedParameter& error = fit.parameters[first + k];
        line.pull = error.value;
        line.uncertainty_with_readings = error.standard_error * line.input.standard_uncertainty;
        for (std::size_t p = 0; p < first; ++p) {
            // The constraint on the term e is (e − e₀)² with e₀ = 0 as stated. The fit minimises
            // |r − J θ − D e|² + (e − e₀)², so dθ̂/de₀ is the covariance of θ̂ and ê.
            const double change =
                fit.covariance(static_cast<Eigen::Index>(p), static_cast<Eigen::Index>(first + k));
            const double part = std::isfinite(change) ? change : 0.0;
            line.sensitivities.push_back(part / line.input.standard_uncertainty);
            budget.from_readings[p] -= part * part;
        }
    }
    for (double& variance : budget.from_readings)
        variance = std::sqrt(std::max(variance, 0.0));
    using Term = measure::ReadingErrors::Term;
    budget.chain_modulus =
        relative_uncertainty(fit, physics::bond_youngs_modulus, &Term::log_modulus);
    budget.chain_damping = relative_uncertainty(fit, physics::bond_damping, &Term::log_damping);
    return budget;
}

} // namespace culm::fit
