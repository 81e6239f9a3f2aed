// SPDX-License-Identifier: BSD-3-Clause
// Sources of frames: an image sequence, a stack of pages in one TIFF file, a video file, or a
// recording of a Photron camera (a header .cih or .cihx and raw pixels .mraw).
#pragma once

#include "measure/track/frames/frame_image.hpp"

#include <cstddef>
#include <cstdint>
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

    /// Numbers of the frames in the recording, ascending. A gap means that the recording reports a
    /// missing frame.
    [[nodiscard]] const std::vector<int>& numbers() const { return numbers_; }
    /// Name of the recording in messages.
    [[nodiscard]] const std::string& name() const { return name_; }
    /// Frames per second as the recording states them; empty if it does not.
    [[nodiscard]] std::optional<double> stated_fps() const { return stated_fps_; }
    /// Whether stated_fps() is the camera's rate. A video file often states its playback rate.
    [[nodiscard]] bool states_camera_rate() const { return states_camera_rate_; }
    /// (numbers) time of each frame as a video file states it, ms; empty if it states none.
    [[nodiscard]] const std::vector<double>& stamps() const { return stamps_; }
    /// Remarks on the recording for the user, one sentence each.
    [[nodiscard]] const std::vector<std::string>& remarks() const { return remarks_; }

    /// Calls `use` once for every position of `wanted`, which lists indices into numbers() in
    /// ascending order, from `threads` threads in any order. Throws core::InputError if a frame
    /// cannot be read, and any exception of `use`; of several errors, that of the first frame.
    virtual void for_each(std::span<const std::size_t> wanted, int threads,
                          const Use& use) const = 0;

  protected:
    std::string name_;
    std::vector<int> numbers_;
    std::vector<double> stamps_;
    std::optional<double> stated_fps_;
    bool states_camera_rate_ = false;
    std::vector<std::string> remarks_;
};

/// Opens the recording `location`, relative to `folder`: a pattern with %d or %05d for the number
/// of an image (PNG, TIFF and other formats of OpenCV), a TIFF file of several pages, a Photron
/// header (.cih or .cihx, with its .mraw in the same folder), or a video file. Throws
/// core::InputError.
[[nodiscard]] std::unique_ptr<FrameSource> open_frames(const std::filesystem::path& folder,
                                                       const std::string& location);

/// The header's data on pixels and time.
struct PhotronHeader {
    int width = 0;
    int height = 0;
    int frames = 0;
    int bits_per_pixel = 0;      ///< as stored: 8, 10, 12 or 16
    int effective_bits = 0;      ///< that the camera digitised; 0 if the header does not say
    bool is_high_aligned = true; ///< the effective bits are the highest stored ones
    double record_rate = 0.0;    ///< frames/s of the camera
    int save_step = 1;           ///< n: every n-th recorded frame was saved

    [[nodiscard]] std::size_t bytes_per_frame() const;
    [[nodiscard]] double frames_per_second() const { return record_rate / save_step; }
};

/// Reads a header. Throws core::InputError naming the entry that is missing or not supported
/// (colour, other file formats than MRaw).
[[nodiscard]] PhotronHeader read_photron_header(const std::filesystem::path& file);

/// Grey values of one frame on a scale to 255. 10 and 12 bits are packed without gaps, highest bit
/// first; 16 bits are stored low byte first. `bytes` has bytes_per_frame() elements.
[[nodiscard]] FrameImage unpack_photron(const PhotronHeader& header,
                                        std::span<const std::uint8_t> bytes);

/// `header` is a .cih or .cihx file; the .mraw file with the same name must be in the same folder.
/// Throws core::InputError, also if the raw file is shorter than the header states.
[[nodiscard]] std::unique_ptr<FrameSource> open_photron(const std::filesystem::path& header);

} // namespace culm::measure
