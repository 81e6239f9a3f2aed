// SPDX-License-Identifier: BSD-3-Clause
// Uncertainty of a calibration, from the noise of the readings and from every stated input.
#pragma once

#include "fit/errors/stated_inputs.hpp"

#include <vector>

namespace culm::fit {

/// One line of an uncertainty budget (JCGM 100, annex H).
struct BudgetInput {
    StatedInput input;
    /// (parameters) change of the fitted parameter with the stated value, per SI unit of it: the
    /// sensitivity coefficient c.
    std::vector<double> sensitivities;
    /// (fitted − stated value)/u; 0 for an input that the readings do not determine.
    double pull = 0.0;
    double uncertainty_with_readings = 0.0; ///< of the input, statement and readings together
};

/// The budget of every fitted parameter. The inputs are independent, so the variance is what the
/// noise of the readings contributes and Σ (c u)² (JCGM 100, 5.1.2).
struct UncertaintyBudget {
    std::vector<BudgetInput> inputs;
    std::vector<double> from_readings; ///< (parameters) standard uncertainty
    std::vector<double> combined;      ///< (parameters) standard uncertainty
    /// Relative standard uncertainties of Y and β without those of the stem's stated numbers, which
    /// change neither the measured frequency nor the measured decay.
    double chain_modulus = 0.0;
    double chain_damping = 0.0;

    /// Part of the parameter's variance that an input, or the readings, contribute.
    [[nodiscard]] double share(std::size_t input, std::size_t parameter) const;
    [[nodiscard]] double share_of_readings(std::size_t parameter) const;
};

/// Of a fit to one recording. A parameter that the readings do not determine has an infinite
/// uncertainty.
[[nodiscard]] UncertaintyBudget uncertainty_budget(const Fit& fit,
                                                   const measure::Measurement& measurement);

} // namespace culm::fit
