// SPDX-License-Identifier: BSD-3-Clause
#include "fit/solve/uncertainty_budget.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace culm::fit {
namespace {

/// Relative standard uncertainty of the parameter; 0 where it is not fitted.
double relative_uncertainty(const Fit& fit, const physics::ParameterId& id,
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

UncertaintyBudget uncertainty_budget(const Fit& fit, const measure::Measurement& measurement) {
    UncertaintyBudget budget;
    const std::size_t count = fit.parameters.size();
    std::vector<double> of_readings;
    for (const FittedParameter& parameter : fit.parameters) {
        budget.combined.push_back(parameter.standard_error);
        of_readings.push_back(std::pow(parameter.standard_error, 2));
    }
    std::vector<StatedInput> inputs = stated_inputs(measurement);
    std::vector<double> of_chain(count, 0.0);
    std::size_t next = 0; // the terms of the inputs are in their order
    for (const Pull& pull : fit.pulls) {
        // Errors of single rows and fitted terms are listed with the noise of the readings.
        if (is_of_row(pull.kind) || pull.kind == ErrorKind::Start)
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
            if (!is_stated || line.input.acts == InputActs::OnClock)
                of_chain[p] += change * change;
        }
    }
    for (std::size_t p = 0; p < count; ++p) {
        of_readings[p] = std::max(of_readings[p], 0.0);
        of_chain[p] += of_readings[p];
        budget.from_readings.push_back(std::sqrt(of_readings[p]));
    }
    budget.chain_modulus = relative_uncertainty(fit, physics::bond_youngs_modulus, of_chain);
    budget.chain_damping = relative_uncertainty(fit, physics::bond_damping, of_chain);
    return budget;
}

} // namespace culm::fit
