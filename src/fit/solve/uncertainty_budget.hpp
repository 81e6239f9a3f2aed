// SPDX-License-Identifier: BSD-3-Clause
// Uncertainty of a calibration, from the noise of the readings and from every stated input.
//
// A number g(θ, z) of the fitted case depends on the fitted parameters θ and on the stated inputs
// z. With C, what the noise of the readings contributes to the covariance of θ̂, and the
// sensitivities c_k = dθ̂/dz_k, its variance is
//
//     ∇gᵀ C ∇g + Σ u_k² (∇gᵀ c_k + ∂g/∂z_k)²          (JCGM 100, 5.1.2 and annex F.1.2.3).
//
// Trap. Parameters that the readings tie together (Y and the mass of a tip) are uncertain by much
// more than the frequency that they have together, and a length that is stated too large makes Y
// too large and leaves the frequency: neither Y alone nor ∇g alone gives the uncertainty of g.
#pragma once

#include "fit/errors/stated_inputs.hpp"

#include <functional>
#include <vector>

#include <Eigen/Core>

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

    /// Part of the parameter's variance that an input, or the readings, contribute.
    [[nodiscard]] double share(std::size_t input, std::size_t parameter) const;
    [[nodiscard]] double share_of_readings(std::size_t parameter) const;
};

/// Of a fit to one recording. A parameter that the readings do not determine has an infinite
/// uncertainty.
[[nodiscard]] UncertaintyBudget uncertainty_budget(const Fit& fit,
                                                   const measure::Measurement& measurement);

/// Numbers of a case, (numbers).
using CaseNumbers = std::function<Eigen::VectorXd(const run::CaseSpec&)>;

/// (numbers) standard uncertainties of numbers of the computed case of such a fit; infinite if one
/// depends on a parameter that the readings do not determine. Derivatives are central differences.
[[nodiscard]] Eigen::VectorXd uncertainties_of(const Fit& fit, const UncertaintyBudget& budget,
                                               const CaseNumbers& numbers);

} // namespace culm::fit
