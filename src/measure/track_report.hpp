// SPDX-License-Identifier: BSD-3-Clause
// How a measurement came about, for people and for other programs.
#pragma once

#include "measure/track.hpp"

#include <filesystem>
#include <string>

#include <nlohmann/json.hpp>

namespace culm::measure {

/// The content of track.json (docs/tracking.md).
[[nodiscard]] nlohmann::ordered_json to_json(const Track& track);

/// A few lines for the screen: what was tracked, release, rest, noise, and all remarks.
[[nodiscard]] std::string summary_text(const Track& track);

/// Writes stem.toml, deflection.csv, track.json and contact_sheet.png into the folder, and
/// overlay.avi if asked for. Throws core::StorageError.
void write_track(const std::filesystem::path& folder, const Track& track, bool with_video);

} // namespace culm::measure
