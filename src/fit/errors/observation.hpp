// SPDX-License-Identifier: BSD-3-Clause
// Errors of what observes the stem: places in a picture, sensors.
#pragma once

#include "fit/solve/fit_result.hpp"

#include <vector>

namespace culm::fit {

/// A lens or uneven light causes an error that depends on the position in the picture. Each row has
/// its own polynomials of the predicted deflection, and all rows together have those of degree 2
/// and 3 (0 and 1 are the rest position and the scale), each with the stated uncertainty. Near the
/// clamp, where the swing is small, the measured deflection would explain its own noise.
[[nodiscard]] std::vector<ErrorTerm> place_terms(const RecordingFit& fit,
                                                 const measure::Measurement& measurement);

/// A constant error of each sensor, and one that grows linearly in time. By default the constant is
/// about as large as the readings, so that the readings alone determine it.
[[nodiscard]] std::vector<ErrorTerm> sensor_terms(const measure::Measurement& measurement);

} // namespace culm::fit
