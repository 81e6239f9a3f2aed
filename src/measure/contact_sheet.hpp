// SPDX-License-Identifier: BSD-3-Clause
// Pictures by which a person sees at a glance whether the right thing was tracked.
#pragma once

#include "measure/track.hpp"

#include <filesystem>

namespace culm::measure {

/// Writes a PNG: sixteen frames from just before the release to the end, on each the tracked axis,
/// its clamp and its rest line, and below them the deflections at all heights over time. Reads the
/// frames again. Throws core::StorageError if the file cannot be written.
void write_contact_sheet(const std::filesystem::path& file, const Track& track);

/// Writes a video (Motion JPEG in AVI, 25 frames/s) of all kept frames with the tracked axis.
void write_overlay_video(const std::filesystem::path& file, const Track& track);

} // namespace culm::measure
