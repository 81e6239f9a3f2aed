// SPDX-License-Identifier: BSD-3-Clause
// What decides between fitted models: evidence that pays for every fitted number.
#pragma once

#include "fit/fit_numbers.hpp"

#include <span>
#include <string>

namespace culm::diagnose {

/// By what the misfits of models that are compared are weighed: all by the same.
struct Yardstick {
    std::vector<double> rmse; ///< (recordings) of the best model, m
    double inflation = 1.0;   ///< of χ²: the best model's reduced χ² where that is above 1
    double share = 1.0;       ///< of the readings that count as independent
    double effective_readings = 1.0;
};

/// From the model that fits best, whose residuals are closest to the noise.
[[nodiscard]] Yardstick yardstick(std::span<const fit::Fit> models);

/// Bayesian information criterion, M · n/N + k ln n, for N readings of which n count as independent
/// and k fitted numbers. The misfit M is a sum over the recordings: χ²/s where the noise is known,
/// with the inflation s because what the best model misses is noise to all; where only the
/// residuals give the noise, their mean square over that of the best model, times the readings.
[[nodiscard]] double bic(const fit::Fit& model, const Yardstick& yardstick);

/// Probability of a fall of χ² at least as large by numbers that mean nothing.
[[nodiscard]] double gain_p_value(const fit::Fit& smaller, const fit::Fit& larger,
                                  const Yardstick& yardstick);
[[nodiscard]] double gain_p_value(double gain, int added);

/// Half of a parameter's 95 % interval.
[[nodiscard]] double interval_half_width(const fit::FittedParameter& parameter);

/// Does that interval contain the value at which the effect is absent?
[[nodiscard]] bool is_absent(const fit::FittedParameter& parameter);

/// "tip_mass.mass_kg stands at its bound, 0 kg".
[[nodiscard]] std::string bound_text(const fit::FittedParameter& parameter);

/// Why the effect cannot be named with this fit, whatever it gains: it failed, a parameter stands
/// at a bound, or none of its sizes is known to be there. Empty if it can. Where recordings have
/// sizes of their own, one that is there is enough.
[[nodiscard]] std::string naming_obstacle(const fit::Fit& fit, const std::string& effect);

/// Could the effect stand in another's place? Also where a parameter ended at a bound, which
/// forbids to name it but does not rule it out, if only it is there at all.
[[nodiscard]] bool is_rival(const fit::Fit& fit, const std::string& effect);

} // namespace culm::diagnose
