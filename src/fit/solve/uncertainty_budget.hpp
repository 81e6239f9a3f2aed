// SPDX-License-Identifier: BSD-3-Clause
// How well a calibration is known: what the noise of the readings and every stated input add.
#pragma once

#include "fit/solve/fit.hpp"

#include <cmath>
#include <string>
#include <vector>

namespace culm::fit {

/// A quantity that enters the model as a number, although it was measured. SI units.
struct StatedInput {
    /// The number in the fitted case. Scale and clamp height move the heights of the case; 0 is
    /// what was stated.
    run::CaseParameter access;
    std::string name; ///< "length", "mass at 156 mm"
    std::string unit; ///< "m"; empty: a share
    double value = 0.0;
    double standard_uncertainty = 0.0; ///< one standard deviation (JCGM 100)
    bool is_default = false;           ///< the file states none
    bool scales_readings = false;      ///< true: deflections grow with it, as the heights do
    bool scales_times = false;         ///< true: it acts on the clock alone; `access` is empty
};

/// Length, section, density, added masses, scale and clamp height of the picture, frame rate. Where
/// the file states no uncertainty that of a careful laboratory counts: length 0.3 mm, clamp height
/// 0.2 mm, scale 0.5 %, every other quantity 1 % (docs/uncertainty.md); a frame rate is exact.
/// Inputs of uncertainty 0 are left out.
[[nodiscard]] std::vector<StatedInput> stated_inputs(const measure::Measurement& measurement);

/// One line of an uncertainty budget (JCGM 100, annex H).
struct BudgetInput {
    StatedInput input;
    /// (parameters) change of the fitted parameter with the input, per SI unit of it: the
    /// sensitivity coefficient c.
    std::vector<double> sensitivities;
    /// (input's value that the readings prefer − stated value)/u, at most the data's weight beside
    /// the statement's. Of an input that the readings cannot tell it is 0.
    double pull = 0.0;
    double uncertainty_with_readings = 0.0; ///< of the input, statement and readings together

    /// Do the readings contradict the statement? By chance they do in one of 370.
    [[nodiscard]] bool is_contradicted() const { return std::abs(pull) > 3.0; }
};

/// Of every fitted parameter. The estimate is the fit with every input at its stated value; its
/// variance is that of the readings' noise plus Σ (c u)² over the inputs, which are independent.
struct UncertaintyBudget {
    std::vector<BudgetInput> inputs;
    std::vector<double> from_readings; ///< (parameters) standard uncertainty
    std::vector<double> combined;      ///< (parameters) standard uncertainty

    /// Part of the parameter's variance that an input, or the readings, contribute.
    [[nodiscard]] double share(std::size_t input, std::size_t parameter) const;
    [[nodiscard]] double share_of_readings(std::size_t parameter) const;
};

/// From one more run with derivatives, by the inputs, at the solution. A parameter that the
/// readings do not tell has an infinite uncertainty. Throws core::NumericalError if the chain
/// cannot be computed with an input changed a little.
[[nodiscard]] UncertaintyBudget uncertainty_budget(const RecordingFit& fit,
                                                   const measure::Measurement& measurement,
                                                   const run::Heartbeat& heartbeat = {});

} // namespace culm::fit
