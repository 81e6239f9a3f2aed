// SPDX-License-Identifier: BSD-3-Clause
// Time from one frame of a measurement to the next.
#pragma once

#include "measure/folder/measurement.hpp"

namespace culm::calibrate {

/// From the camera's rate if that is known, else the median distance of the times, s.
[[nodiscard]] double frame_period(const measure::Measurement& measurement);

} // namespace culm::calibrate
