// SPDX-License-Identifier: BSD-3-Clause
// Where frames come from: an image sequence, a video file, or a Photron recording.
#pragma once

#include "measure/frame_image.hpp"

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace culm::measure {

/// A recording, read frame by frame. All functions are callable from several threads.
class FrameSource {
  public:
    /// Called with the position in the list of wanted frames and the frame.
    using Use = std::function<void(std::size_t, const FrameImage&)>;

    FrameSource() = default;
    virtual ~FrameSource() = default;
    FrameSource(const FrameSource&) = delete;
    FrameSource& operator=(const FrameSource&) = delete;

    /// Numbers of the frames in the recording, ascending. A gap means that the recording itself
    /// says that a frame is missing.
    [[nodiscard]] virtual const std::vector<int>& numbers() const = 0;
    /// What messages call the recording.
    [[nodiscard]] virtual std::string name() const = 0;
    /// Frames per second as the recording states them; empty if it does not.
    [[nodiscard]] virtual std::optional<double> stated_fps() const { return std::nullopt; }
    /// Whether stated_fps() is the camera's rate. A video file's rate is often that of playback.
    [[nodiscard]] virtual bool states_camera_rate() const { return false; }
    /// What a person should know of the recording, one sentence each.
    [[nodiscard]] virtual std::vector<std::string> remarks() const { return {}; }

    /// Calls `use` once for every position of `wanted`, which lists indices into numbers() in
    /// ascending order, from `threads` threads in any order. Throws core::InputError if a frame
    /// cannot be read, and what `use` throws; of several errors that of the first frame.
    virtual void for_each(std::span<const std::size_t> wanted, int threads,
                          const Use& use) const = 0;
};

/// Opens what `location` names, relative to `folder`: a pattern with %d or %05d for the number of
/// an image (PNG, TIFF and what else OpenCV reads), a Photron header (.cih or .cihx, with its .mraw
/// beside it), or a video file. Throws core::InputError.
[[nodiscard]] std::unique_ptr<FrameSource> open_frames(const std::filesystem::path& folder,
                                                       const std::string& location);

} // namespace culm::measure
