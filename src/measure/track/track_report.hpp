// SPDX-License-Identifier: BSD-3-Clause
// Output of `culm track` in addition to the measurement (a report, a contact sheet),
// and a first look at a recording without scale and specimen for `culm setup`.
#pragma once

#include "measure/track/track.hpp"

#include <filesystem>
#include <string>

#include <nlohmann/json_fwd.hpp>

namespace culm::measure {

/// The content of track.json (docs/tracking.md).
[[nodiscard]] nlohmann::json track_json(const Track& track);
[[nodiscard]] nlohmann::json track_schema();

/// A few lines for the screen: what was tracked, release, rest, noise, and all remarks.
[[nodiscard]] std::string summary_text(const Track& track);

/// Writes stem.toml, deflection.csv, track.json and contact_sheet.png into the folder. Throws
/// core::StorageError.
void write_track(const std::filesystem::path& folder, const Track& track);

/// Writes a PNG: sixteen frames from just before the release to the end, on each the tracked axis,
/// its clamp and its rest line. Reads the frames again. Throws core::StorageError if the file
/// cannot be written.
void write_contact_sheet(const std::filesystem::path& file, const Track& track);

/// Finds the stem with the tracker's own survey and first pass. The stem's width, which the tracker
/// computes from the scale, is the one of some widths at which the stem is clearest. In a
/// long recording only the part about the release is searched: as many frames as are read in some
/// tens of seconds. The result is for the page of `culm setup` (postprocess/setup.py): what was
/// found, in pixels of the frames as recorded, some frames as JPEG of at most 900 pixels, the
/// allowed numbers of video.toml, and the thresholds of the tracker's checks. Throws
/// core::InputError if frames cannot be read.
[[nodiscard]] nlohmann::ordered_json survey_video(const FrameSource& source, int threads);

} // namespace culm::measure
