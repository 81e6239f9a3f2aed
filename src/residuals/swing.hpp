// SPDX-License-Identifier: BSD-3-Clause
// The measured coordinate of the strongest shape over the heights; the backbones of measurement and
// model, and Eq. 1 at every height.
#pragma once

#include "fit/fit.hpp"
#include "measure/folder/measurement.hpp"
#include "reduce/backbone/backbone.hpp"
#include "residuals/stem_ring_downs.hpp"

#include <optional>
#include <vector>

#include <Eigen/Core>

namespace culm::residuals {

/// The layout of readings, (frames, rows).
using RowMajorMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Readings, (frames, rows), over their noise; 0 for those that were not seen.
[[nodiscard]] Eigen::MatrixXd over_noise(const fit::RecordingFit& fit,
                                         const std::vector<double>& readings);

/// The heights move together in the shape with most of the motion (the first mode if one mode
/// dominates, the common shape of two close modes). Coordinates are those of the row where the
/// shape is largest, m.
struct Swing {
    std::vector<double> times;    ///< (frames), s
    std::vector<double> measured; ///< (frames), m; NaN where no row was seen
    double noise = 0.0;           ///< of a measured coordinate with all rows, m
    double frequency = 0.0;       ///< of the fitted chain's first mode, Hz
};

/// The shape is the first right singular vector of the predicted readings after the release (of the
/// measured ones, if the model does not move), weighted by the noise.
[[nodiscard]] Swing swing_of(const fit::RecordingFit& fit, const measure::Measurement& measurement);

/// Backbones of the measured and of the modelled readings, found in the same way.
struct BackbonesOfBoth {
    std::vector<reduce::ModeBackbone> measured;
    std::vector<reduce::ModeBackbone> modelled; ///< at the same times and heights
};

template <class To>
void describe(To& to, const BackbonesOfBoth& both) {
    to("measured", both.measured);
    to("modelled", both.modelled);
}

/// Over the time of the fit. A modelled backbone ends with the amplitudes of the measured one.
[[nodiscard]] BackbonesOfBoth backbones_of_both(const fit::RecordingFit& fit,
                                                const measure::Measurement& measurement);

/// The readings for a backbone; `readings` (times, heights) instead of the measured ones.
[[nodiscard]] reduce::BackboneInput backbone_input(const measure::Measurement& measurement,
                                                   std::span<const double> readings = {});

struct RingDownsOfBoth {
    StemRingDowns measured;
    StemRingDowns modelled; ///< at the same times and heights
};

/// Eq. 1 with a free phase, fitted in the same way to both, over the time of the fit.
[[nodiscard]] RingDownsOfBoth ring_downs_of_both(const fit::RecordingFit& fit,
                                                 const measure::Measurement& measurement);

} // namespace culm::residuals
