// SPDX-License-Identifier: BSD-3-Clause
// Noise as a fit's residuals have it, drawn at random.
#pragma once

#include "diagnose/model_fit.hpp"

#include <cstdint>

#include <Eigen/Core>

namespace culm::diagnose {

/// Draw number `draw` of noise over itself, (readings of all recordings): Gaussian, and in every
/// row correlated from frame to frame as the residuals of `fit` are where that is more than chance
/// (first-order autoregression). Zero where nothing was seen. The same on every rank.
[[nodiscard]] Eigen::VectorXd null_noise(const ModelFit& fit, std::uint64_t draw);

} // namespace culm::diagnose
