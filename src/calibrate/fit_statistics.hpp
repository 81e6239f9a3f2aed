// SPDX-License-Identifier: BSD-3-Clause
// What a solved fit tells: residuals, χ², covariance, which parameters stand at a bound.
#pragma once

#include "calibrate/joint_fit.hpp"

namespace culm::calibrate {

/// Fills `fit` from the model, times, prediction, noise (by which the residuals were weighted) and
/// is_noise_known of its parts. Held parameters get a standard error of 0. Where the noise of a
/// part is not known it becomes the residuals' own, and the part's reduced χ² 1.
void add_statistics(std::span<const measure::Measurement> measurements, const JointLayout& layout,
                    const std::vector<bool>& is_held, JointFit& fit);

} // namespace culm::calibrate
