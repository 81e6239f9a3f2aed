// SPDX-License-Identifier: BSD-3-Clause
// Noise as a fit's residuals have it, drawn at random.
#pragma once

#include "fit/fit_model.hpp"

#include <Eigen/Core>

namespace culm::residuals {

/// Noise over itself, (readings of all recordings, draws): Gaussian, and in every row correlated
/// from frame to frame as the residuals of `fit` are where that is more than chance (first-order
/// autoregression). Zero where nothing was seen. The same on every rank.
[[nodiscard]] Eigen::MatrixXd null_noise(const fit::Fit& fit, int draws);

} // namespace culm::residuals
