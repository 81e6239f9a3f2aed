// SPDX-License-Identifier: BSD-3-Clause
// A foreign recording as a measurement.
#pragma once

#include "measure/folder/measurement.hpp"
#include "measure/import/import_mapping.hpp"

namespace culm::measure {

/// Reads the mapping's source and makes a measurement of it: the mean over the columns or markers
/// of each height, less the motion of the clamp's, from the zero that the mapping chooses, with t =
/// 0 at the release. A release to be detected lies where the mean deflection leaves the level of
/// the first frames for good; between two frames by the square root of the travel, which grows
/// linearly in time under a sudden force. Where the mapping gives no noise it is the scatter about
/// the mean before the release (at least 8 frames), and noise_source says so. Throws
/// core::InputError.
[[nodiscard]] Measurement import_recording(const ImportMapping& mapping);

} // namespace culm::measure
