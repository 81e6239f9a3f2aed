// SPDX-License-Identifier: BSD-3-Clause
#include "core/error.hpp"
#include "measure/frame_from_opencv.hpp"
#include "measure/parallel_frames.hpp"
#include "measure/picture_files.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/core.h>
#include <opencv2/videoio.hpp>

namespace culm::measure {
namespace {

/// A damaged container may state any time; more lost frames than this leave no recording.
constexpr double most_missing = 1e6;

cv::VideoCapture open(const std::string& file) {
    cv::VideoCapture video(file);
    if (!video.isOpened())
        throw core::InputError(fmt::format("{}: is not a video that OpenCV can read", file));
    return video;
}

class VideoFile final : public FrameSource {
  public:
    explicit VideoFile(const std::filesystem::path& file) : file_(file.string()) {
        cv::VideoCapture video = open(file_);
        if (const double fps = video.get(cv::CAP_PROP_FPS); fps > 0.0 && std::isfinite(fps))
            stated_fps_ = fps;
        // The number of frames that a container states is often an estimate.
        std::vector<double> stamps;
        while (video.grab()) {
            numbers_.push_back(static_cast<int>(numbers_.size()));
            stamps.push_back(video.get(cv::CAP_PROP_POS_MSEC));
        }
        if (numbers_.empty())
            throw core::InputError(fmt::format("{}: holds no frame", file_));
        find_missing_frames(stamps);
    }

    [[nodiscard]] const std::vector<int>& numbers() const override { return numbers_; }
    [[nodiscard]] std::string name() const override { return file_; }
    [[nodiscard]] std::optional<double> stated_fps() const override { return stated_fps_; }
    [[nodiscard]] std::vector<std::string> remarks() const override { return remarks_; }

    /// A video is decoded in order: the threads take turns at it and track what they got.
    void for_each(std::span<const std::size_t> wanted, int threads, const Use& use) const override {
        cv::VideoCapture video = open(file_);
        std::mutex turn;
        std::size_t next = 0;
        std::size_t position = 0; // of the decoder
        FirstError error;
        on_threads(threads, [&] {
            while (true) {
                std::size_t i = 0;
                cv::Mat picture;
                {
                    const std::scoped_lock lock(turn);
                    if (next >= wanted.size())
                        return;
                    i = next++;
                    for (; position < wanted[i]; ++position)
                        video.grab();
                    cv::Mat decoded;
                    video.read(decoded);
                    ++position;
                    picture = decoded.clone();
                }
                try {
                    if (picture.empty())
                        throw core::InputError(
                            fmt::format("{}: frame {} cannot be decoded", file_, wanted[i]));
                    use(i, frame_from(picture, file_));
                } catch (...) {
                    error.keep(i);
                }
            }
        });
        error.rethrow();
    }

  private:
    /// Time stamps that skip a frame time mean frames that were lost: the numbers leave a gap.
    void find_missing_frames(const std::vector<double>& stamps) {
        std::vector<double> steps;
        for (std::size_t i = 1; i < stamps.size(); ++i)
            steps.push_back(stamps[i] - stamps[i - 1]);
        if (steps.size() < 4)
            return;
        std::vector<double> sorted = steps;
        std::ranges::nth_element(sorted, sorted.begin() + std::ptrdiff_t(sorted.size() / 2));
        const double usual = sorted[sorted.size() / 2];
        if (!(usual > 0.0))
            return;
        int shift = 0;
        for (std::size_t i = 1; i < stamps.size(); ++i) {
            // Containers round time stamps, often to a millisecond.
            const double skipped = std::round(steps[i - 1] / usual) - 1.0;
            if (!(skipped <= most_missing - double(shift)))
                throw core::InputError(fmt::format(
                    "{}: the time stamps skip {:g} frames after frame {}; at most {:g} may be "
                    "missing",
                    file_, skipped, numbers_[i - 1], most_missing));
            const int missing = static_cast<int>(std::max(-1.0, skipped));
            if (missing > 0 && steps[i - 1] > 1.5 * usual + 1.0) {
                remarks_.push_back(
                    fmt::format("the time stamps skip {} frame time{} after frame {}", missing,
                                missing == 1 ? "" : "s", numbers_[i - 1]));
                shift += missing;
            }
            numbers_[i] += shift;
        }
    }

    std::string file_;
    std::vector<int> numbers_;
    std::optional<double> stated_fps_;
    std::vector<std::string> remarks_;
};

} // namespace

std::unique_ptr<FrameSource> open_video_file(const std::filesystem::path& file) {
    return std::make_unique<VideoFile>(file);
}

} // namespace culm::measure
