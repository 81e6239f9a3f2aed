// SPDX-License-Identifier: BSD-3-Clause
// Tracking a stem in a recording: the settings in video.toml, the survey, and the result.
#pragma once

#include "core/interval.hpp"
#include "measure/folder/measurement.hpp"
#include "measure/release/swing_release.hpp"
#include "measure/track/axis_record.hpp"
#include "measure/track/frames/frame_image.hpp"
#include "measure/track/frames/frame_source.hpp"
#include "measure/track/stem_trace.hpp"

#include <cmath>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace culm::measure {

/// Empty values are detected. Rows and columns are those of the frame, counted from 0 at the top
/// left, with whole numbers at pixel centres.
struct TrackSettings {
    std::filesystem::path file;
    std::string frames; ///< their path, relative to the file's folder (open_frames)
    std::optional<int> first_frame;
    std::optional<int> frame_count;
    std::optional<double> fps;       ///< of the camera, 1/s
    double metres_per_pixel = 0.0;   ///< m
    std::optional<int> width;        ///< of the frames, pixels; only checked
    std::optional<int> height;       ///< of the frames, pixels; only checked
    std::optional<Up> up;            ///< from the clamp to the tip
    std::optional<double> clamp;     ///< row (of a sideways stem: column) where the stem is clamped
    std::optional<double> axis;      ///< column (of a sideways stem: row) of the stem at rest
    std::optional<int> pull_sign;    ///< +1: the stem is pulled toward larger columns (rows)
    std::optional<Band> band;        ///< of coloured frames
    std::optional<int> stem_sign;    ///< +1: brighter than the background, −1: darker
    std::optional<double> threshold; ///< contrast to the background that makes a pixel the stem's
    std::vector<double> heights;     ///< above the clamp, m; empty: evenly spaced
    std::optional<double> height_step; ///< m
    int rows_per_height = 5;
    std::optional<int> release_frame;         ///< the last one in which the stem is held
    std::optional<int> frames_before_release; ///< kept of those before; empty: 50 at most
    bool trim_after_rest = true;
    std::vector<int> missing_frames; ///< numbers that the camera left out without leaving a gap
    Measurement description;         ///< stem, release, gravity; no times and deflections
};

/// Allowed numbers of video.toml.
struct TrackLimits {
    static constexpr core::Interval fps{0.0, 1e8, true};
    static constexpr core::Interval mm_per_px{0.0, 1e3, true};
    static constexpr core::Interval frame_numbers{0.0, 1e9};
    static constexpr core::Interval coordinates{-1e5, 1e5}; ///< a clamp may be outside the picture
};

/// Reads video.toml (format: docs/tracking.md). Throws core::InputError with every fault.
[[nodiscard]] TrackSettings read_track_settings(const std::filesystem::path& file);

/// The view of a frame in which the stem is upright and has the highest contrast.
struct StemView {
    Up up = Up::DecreasingRow;
    Band band = Band::Red;
    int sign = 1; ///< +1: brighter than its background, −1: darker

    friend bool operator==(const StemView&, const StemView&) = default;
};

/// Parameters of tracking a frame; rows and columns are those of the upright picture.
struct StemSurvey {
    StemView view;
    int frame_width = 0; ///< pixels, as recorded
    int frame_height = 0;
    int bands = 1;
    TraceOptions trace;
    double clamp_row = 0.0; ///< where the height is 0
    double noise = 0.0;     ///< of the contrast, grey values
    double contrast = 0.0;  ///< of the stem against its background, median over rows, grey values
    double apparent_width = 0.0; ///< of the stem, pixels
    std::vector<std::string> remarks;
};

/// At most `count` (2 or more) of the wanted frames, the first and the last included.
[[nodiscard]] std::vector<std::size_t> evenly_spaced(std::span<const std::size_t> wanted,
                                                     std::size_t count);

/// Surveys up to 40 of the `wanted` frames. Determines the values that the settings do not specify:
/// the stem's orientation (the end that moves least is clamped), the band and the sign with the
/// clearest stem, clutter (pixels with a high contrast in all frames that do not continue the
/// moving part), the threshold (half the stem's contrast in every row; Otsu's method fails if the
/// stem covers two per cent of the pixels) and the clamp's row. Throws core::InputError if no stem
/// is found.
[[nodiscard]] StemSurvey survey_stem(const FrameSource& source, std::span<const std::size_t> wanted,
                                     const TrackSettings& settings, int threads);

/// When the wanted frames were taken.
struct FrameClock {
    double frames_per_second = 0.0; ///< of the camera
    std::string rate_source;        ///< of that rate, as "of video.toml"
    std::vector<int> numbers;       ///< as the camera would have counted them
    std::vector<double> times;      ///< in frames: the numbers, if they last equally long
};

/// Adds remarks if the rate of a video file is not that of video.toml, and if the frames last
/// unequally long by the file's time stamps, which then are their times. Throws core::InputError
/// if no rate is known or a camera's header contradicts video.toml.
[[nodiscard]] FrameClock frame_clock(const FrameSource& source, std::span<const std::size_t> wanted,
                                     const TrackSettings& settings,
                                     std::vector<std::string>& remarks);

struct RingDownWindow {
    SwingRelease release;                  ///< at the place watched, in frames and pixels
    std::size_t last_held = 0;             ///< index of the last frame in which the stem is held
    std::size_t held_frames = 0;           ///< up to and including it, held at the same position
    std::optional<std::size_t> rest_begin; ///< index of the first frame at rest
    /// (places) column, pixels: the median of the frames after the motion has died down or, if the
    /// recording ends before, the centre of the decaying swing.
    std::vector<double> rest;
    bool is_rest_seen = false;
    std::size_t watched = 0;   ///< the place
    std::vector<double> noise; ///< (places) standard deviation of a reading, pixels; NaN unknown
    std::string noise_source;  ///< from which frames
    /// (locations) standard deviation of a reading about one damped sine in the last cycles,
    /// pixels. It includes errors that a still stem does not have. NaN if unknown.
    std::vector<double> moving_noise;
    std::vector<std::string> remarks;

    /// Of the swing, in frames: the mean over all that are seen.
    [[nodiscard]] double period() const { return mean_period(release.passages); }
    [[nodiscard]] double cycles_per_frame() const { return 1.0 / period(); }
    /// −1 if the stem was pulled toward smaller columns, otherwise 1.
    [[nodiscard]] int sign() const { return release.held < release.rest ? -1 : 1; }
    /// Distance from the rest at which it was held, pixels.
    [[nodiscard]] double pull() const { return std::abs(release.held - release.rest); }
};

struct WindowOptions {
    std::string source;                       ///< name of the recording in messages
    double length = 0.0;                      ///< of the stem, pixels
    std::optional<std::size_t> release_frame; ///< index of the last held frame, if given
};

/// Uses the highest location that is seen in nearly all frames and throughout the release
/// (find_swing_release). Rest: the time after which the range of a period is within the noise; the
/// centre of the swing if it is not seen. Noise: the spread while held (at least 5 frames), else at
/// rest, else about one sine in the last cycles; its correlation between frames, if 8
/// frames are still. Remarks report a release whose moment is uncertain, and jumps that look like
/// lost frames without a gap in the numbers. Throws core::InputError with the observed motion if
/// the stem does not move, is not released, does not swing, or was released before the first frame.
[[nodiscard]] RingDownWindow find_ring_down(const AxisRecord& record, const WindowOptions& options);

/// A measurement and its intermediate results.
struct Track {
    Measurement measurement;
    TrackSettings settings;
    std::string source;
    double frames_per_second = 0.0;
    std::string rate_source;                 ///< FrameClock::rate_source
    std::vector<std::size_t> source_indices; ///< of the frames of `rows`, into the source
    StemSurvey survey;
    AxisRecord rows;    ///< every row of the upright picture, every frame
    AxisRecord heights; ///< at the measurement's heights, in pixels above the clamp
    RingDownWindow window;
    std::size_t first_kept = 0; ///< index of the first frame in the measurement
    std::size_t last_kept = 0;
    std::vector<std::string> remarks; ///< for the user, one sentence each
};

/// Thresholds of add_doubts(), which the page of `culm setup` applies as well.
struct TrackTolerances {
    static constexpr double noted_length = 0.04;   ///< of the visible length, relative
    static constexpr double refused_length = 0.15; ///< above a detected clamp
    static constexpr double length_pixels = 6.0;   ///< in addition
    // Blur and the threshold change the apparent width, but not by half.
    static constexpr double smallest_width = 0.6; ///< apparent over expected
    static constexpr double largest_width = 1.6;
    static constexpr double width_pixels = 1.0;       ///< in addition
    static constexpr double cycles_per_frame = 0.125; ///< of a swing that is well resolved
    static constexpr double softest = 1e7;            ///< Young's modulus of plant stems, Pa
    static constexpr double stiffest = 1e11;
};

/// Traces all rows in the frames of `track`, whose numbers are in `track.rows`, as `track.survey`
/// says. Returns which frames repeat the previous one.
std::vector<bool> track_rows(Track& track, const FrameSource& source, int threads);

/// Sets the columns of `track` at these heights, pixels above the clamp, from those of its rows.
void set_heights(Track& track, const std::vector<double>& heights);

/// Row of the tip while the stem is still and straight: the highest row seen in most frames.
[[nodiscard]] std::optional<double> tip_row(const Track& track);

/// Side of positive deflections: "left", "right", "top" or "bottom".
[[nodiscard]] const char* positive_side(const Track& track);

/// Replaces the columns of the rows that the heights of `track` use by those of match_row(), with
/// their uncertainties. Profiles are those of the frames in which the stem is slowest, one for the
/// rows of each height. The exposure is that of the settings; otherwise it is determined from the
/// fastest frames and returned, in frames, if they show one.
std::optional<double> match_rows(Track& track, const FrameSource& source, int threads);

/// Tracks the recording of the settings; the threads share its frames. The result does not depend
/// on the number of threads. Throws core::InputError with the reason if the recording gives no
/// reliable measurement.
[[nodiscard]] Track track_video(const TrackSettings& settings, int threads = 1);

/// Young's modulus, Pa, with which a uniform Euler–Bernoulli cantilever of the stem's length,
/// section and density would swing as the recording shows, f = 1.8751²/(2π L²) √(EI/μ). It is
/// proportional to the square of the frame rate, so it may reveal a wrong rate.
[[nodiscard]] double modulus_of_swing(const Track& track);

/// Adds remarks on inconsistencies: missing frames, a swing too fast for the frame rate, a stem
/// with another width or length than the scale implies, a modulus that no plant stem has (a wrong
/// rate or scale), a rest position away from the stated axis, a pull to the other side. Throws
/// core::InputError if the length seen above a detected clamp is wrong by more than 15 %, because
/// then all heights are wrong.
void add_doubts(Track& track);

} // namespace culm::measure
