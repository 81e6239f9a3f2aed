// SPDX-License-Identifier: BSD-3-Clause
#include "fit/solve/uncertainty_budget.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace culm::fit {
namespace {

/// Relative standard uncertainty of the parameter; 0 where it is not fitted.
double relative_uncertainty(const RecordingFit& fit, const physics::ParameterId& id,
                            const std::vector<double>& variances) {
    for (std::size_t p = 0; p < variances.size(); ++p)
        if (fit.parameters[p].id == id)
            return std::sqrt(variances[p]) / fit.parameters[p].value;
    return 0.0;
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

UncertaintyBudget uncertainty_budget(const RecordingFit& stated, const RecordingFit& judged,
                                     const measure::Measurement& measurement) {
    UncertaintyBudget budget;
    const std::size_t count = stated.parameters.size();
    std::vector<double> of_readings;
    for (const FittedParameter& parameter : stated.parameters) {
        budget.combined.push_back(parameter.standard_error);
        of_readings.push_back(std::pow(parameter.standard_error, 2));
    }
    const std::size_t first = judged.model.first_error();
    std::vector<StatedInput> inputs = stated_inputs(measurement);
    std::vector<double> of_chain(count, 0.0);
    for (std::size_t k = 0; k < judged.model.error_values.size(); ++k) {
        const ReadingErrors::Term& term = judged.model.errors->terms[k];
        // Position errors of single rows and the terms of every model are listed with the noise of
        // the readings.
        if (term.is_of_row || term.is_in_every_model)
            continue;
        const bool is_stated = k < inputs.size();
        BudgetInput& line = budget.inputs.emplace_back();
        if (is_stated) {
            line.input = std::move(inputs[k]);
        } else { // a number that the model adds
            line.input.name = term.name;
            line.input.unit = "1";
            line.input.standard_uncertainty = 1.0;
        }
        const FittedParameter& error = judged.parameters[first + k];
        line.pull = error.value;
        line.uncertainty_with_readings = error.standard_error * line.input.standard_uncertainty;
        for (std::size_t p = 0; p < count; ++p) {
            // If the stated value is larger by u, the same readings give a parameter that is
            // smaller by the change.
            const double change =
                stated.input_changes(static_cast<Eigen::Index>(p), static_cast<Eigen::Index>(k));
            line.sensitivities.push_back(-change / line.input.standard_uncertainty);
            of_readings[p] -= change * change;
            if (!is_stated || line.input.acts == InputActs::OnClock)
                of_chain[p] += change * change;
        }
    }
    for (std::size_t p = 0; p < count; ++p) {
        of_readings[p] = std::max(of_readings[p], 0.0);
        of_chain[p] += of_readings[p];
        budget.from_readings.push_back(std::sqrt(of_readings[p]));
    }
    budget.chain_modulus = relative_uncertainty(stated, physics::bond_youngs_modulus, of_chain);
    budget.chain_damping = relative_uncertainty(stated, physics::bond_damping, of_chain);
    return budget;
}

} // namespace culm::fit
