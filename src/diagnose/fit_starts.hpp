// SPDX-License-Identifier: BSD-3-Clause
// Where the fit of a model with effects begins.
#pragma once

#include "calibrate/chain_fit.hpp"

#include <string>
#include <vector>

namespace culm::diagnose {

/// Is the parameter ("effect.parameter") a place, an angle or a time scale, which means nothing
/// while the effect has no size?
[[nodiscard]] bool is_place(const std::string& parameter);

/// The value of an effect's parameter at which the effect is absent: 0, or for a factor 1.
[[nodiscard]] double absent_value(const std::string& parameter);

/// Frequencies (Hz) at which the residuals of a fit are strongest, at most `count`.
[[nodiscard]] std::vector<double> residual_peaks(const calibrate::ChainFit& fit, std::size_t count);

/// Starts for a fit of `model` that contains what `smaller` was fitted with. Values of parameters
/// that both have come from `smaller`. Places, angles and time scales of the others start from
/// several values each. In every start Y and β are changed so that the first mode keeps its
/// frequency and decay: an effect that shifts the frequency would otherwise begin cycles away.
[[nodiscard]] std::vector<calibrate::StemModel> fit_starts(const calibrate::StemModel& model,
                                                           const calibrate::ChainFit& smaller);

} // namespace culm::diagnose
