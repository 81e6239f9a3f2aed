// SPDX-License-Identifier: BSD-3-Clause
// What a solved fit tells: residuals, χ², covariance, which parameters stand at a bound.
#pragma once

#include "calibrate/chain_fit.hpp"

namespace culm::calibrate {

/// Fills `fit` from its model, times, prediction, noise and is_noise_known. Held parameters get a
/// standard error of 0. Where the noise is not known it becomes the residuals' own, and the
/// reduced χ² 1.
void add_statistics(const measure::Measurement& measurement, const std::vector<bool>& is_held,
                    ChainFit& fit);

} // namespace culm::calibrate
