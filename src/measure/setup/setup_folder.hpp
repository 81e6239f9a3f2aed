// SPDX-License-Identifier: BSD-3-Clause
// The folder in which a recording is set up, with a link to its pictures.
#pragma once

#include <filesystem>
#include <string>

namespace culm::measure {

/// The recording that the user names, as a location for open_frames() in the current folder: a
/// video file, a Photron header, a pattern like frames/%05d.png, or a folder with a numbered image
/// sequence. Throws core::InputError.
[[nodiscard]] std::string recording_location(const std::string& named);

/// Creates `folder` and makes the recording reachable from it, by a link "frames" to the folder of
/// the recording unless this is in `folder` already. Returns its location relative to `folder`.
/// Throws core::InputError if the folder has a video.toml or another "frames", core::StorageError
/// if it cannot be written.
[[nodiscard]] std::string make_setup_folder(const std::filesystem::path& folder,
                                            const std::string& location);

} // namespace culm::measure
