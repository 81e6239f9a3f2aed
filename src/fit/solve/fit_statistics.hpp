// SPDX-License-Identifier: BSD-3-Clause
// Residuals and parameters of a fit whose parts have their models and predictions.
#pragma once

#include "fit/solve/fit_result.hpp"

#include <span>
#include <vector>

namespace culm::fit {

/// Residuals, their number and their root mean square.
void add_residuals(std::span<const ObservedRecording> measurements, Fit& fit);

/// The parameters of the parts and of all, without standard errors. Those at a bound that are not
/// held (`is_held`; joint parameters) are the fit's reason.
void add_parameters(const JointLayout& layout, const std::vector<bool>& is_held, Fit& fit);

} // namespace culm::fit
