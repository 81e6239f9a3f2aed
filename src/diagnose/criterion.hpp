// SPDX-License-Identifier: BSD-3-Clause
// The information criterion that compares fitted models.
#pragma once

#include "fit/fit_numbers.hpp"

#include <span>
#include <vector>

namespace culm::diagnose {

/// How the misfits of models that are compared are weighted: by the same numbers for all.
struct Criterion {
    std::vector<double> rmse; ///< (recordings) of the best model, m
    double inflation = 1.0;   ///< of χ²: the best model's reduced χ² where that is above 1
    double share = 1.0;       ///< of the readings that count as independent
    double effective_readings = 1.0;
};

/// Has `one` the larger likelihood? Recordings of unknown noise count by n ln(rms²).
[[nodiscard]] bool is_likelier(const fit::Fit& one, const fit::Fit& other);

/// From the model that fits best, because its residuals are closest to the noise. The second form:
/// the models and one more.
[[nodiscard]] Criterion criterion(std::span<const fit::Fit> models);
[[nodiscard]] Criterion criterion(const fit::Fit& one, std::span<const fit::Fit> others);

/// Bayesian information criterion, M · n/N + k ln n, for N readings of which n count as independent
/// and k fitted numbers. The misfit M is a sum over the recordings: χ²/s where the noise is known,
/// with the inflation s because what the best model misses is noise to all; where only the
/// residuals give the noise, their mean square over that of the best model, times the readings.
[[nodiscard]] double bic(const fit::Fit& model, const Criterion& criterion);

/// Probability of a fall of χ² at least as large by `added` numbers that mean nothing.
[[nodiscard]] double gain_p_value(double gain, int added);
[[nodiscard]] double gain_p_value(const fit::Fit& smaller, const fit::Fit& larger,
                                  const Criterion& criterion);

} // namespace culm::diagnose
