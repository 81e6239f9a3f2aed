// SPDX-License-Identifier: BSD-3-Clause
#include "measure/track/frames/frame_source.hpp"

#include "core/error.hpp"
#include "core/order_statistics.hpp"
#include "measure/track/frames/frame_from_opencv.hpp"
#include "measure/track/frames/parallel_frames.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string_view>

#include <fmt/core.h>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/videoio.hpp>

namespace culm::measure {

namespace {

/// As in video.toml. Missing frames increase the numbers, which must fit into an int.
constexpr int largest_frame_number = 1'000'000'000;

/// A file name that contains the frame's number.
struct NumberedName {
    std::string before;
    std::string after;
    std::size_t digits = 1; ///< minimum; padded with zeros

    [[nodiscard]] std::string file(int number) const {
        return fmt::format("{}{:0{}}{}", before, number, digits, after);
    }
    /// The number in a file name of this form, or −1.
    [[nodiscard]] int number_in(std::string_view name) const {
        if (name.size() <= before.size() + after.size() || !name.starts_with(before) ||
            !name.ends_with(after))
            return -1;
        const std::string_view text =
            name.substr(before.size(), name.size() - before.size() - after.size());
        int number = -1;
        const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
        // The number must reproduce the name: if 00001.png exists, 1.png would be a second frame
        // with the same number.
        const bool is_number = error == std::errc{} && end == text.data() + text.size();
        return is_number && number >= 0 && number <= largest_frame_number && file(number) == name
                   ? number
                   : -1;
    }
};

NumberedName parse_name(const std::string& name, const std::string& pattern) {
    const std::size_t begin = name.find('%');
    const std::size_t end = name.find('d', begin);
    NumberedName result;
    bool is_valid = begin != std::string::npos && end != std::string::npos &&
                    name.find('%', begin + 1) == std::string::npos;
    if (is_valid) {
        const std::string digits = name.substr(begin + 1, end - begin - 1);
        is_valid = digits.empty() || (digits.size() <= 3 && digits.front() == '0' &&
                                      digits.find_first_not_of("0123456789") == std::string::npos);
        result.before = name.substr(0, begin);
        result.after = name.substr(end + 1);
        result.digits = is_valid && digits.size() > 1 ? std::stoul(digits) : 1;
    }
    if (!is_valid)
        throw core::InputError(fmt::format(
            "{}: the file name must contain the frame number once, as %d or like %05d", pattern));
    return result;
}

/// A numbered image sequence; the file name of its path contains one %d or %0Nd.
class ImageSequence final : public FrameSource {
  public:
    explicit ImageSequence(const std::filesystem::path& pattern)
        : folder_(pattern.parent_path()),
          names_(parse_name(pattern.filename().string(), pattern.string())) {
        name_ = pattern.string();
        std::error_code error;
        for (const auto& entry : std::filesystem::directory_iterator(folder_, error))
            if (const int number = names_.number_in(entry.path().filename().string()); number >= 0)
                numbers_.push_back(number);
        if (error)
            throw core::InputError(
                fmt::format("{}: cannot be read: {}", folder_.string(), error.message()));
        if (numbers_.empty())
            throw core::InputError(fmt::format("{}: no file has a name of this form", name_));
        std::ranges::sort(numbers_);
    }

    void for_each(std::span<const std::size_t> wanted, int threads, const Use& use) const override {
        for_each_index(wanted.size(), threads, [&](std::size_t i) {
            const std::string file = (folder_ / names_.file(numbers_.at(wanted[i]))).string();
            const cv::Mat picture = cv::imread(file, cv::IMREAD_UNCHANGED);
            if (picture.empty())
                throw core::InputError(fmt::format("{}: is not a readable picture", file));
            use(i, frame_from(picture, file));
        });
    }

  private:
    std::filesystem::path folder_;
    NumberedName names_;
};

/// The pages of one TIFF file, as ImageJ and high-speed cameras write them.
class PageStack final : public FrameSource {
  public:
    explicit PageStack(const std::filesystem::path& file) {
        name_ = file.string();
        const std::size_t pages = cv::imcount(name_, cv::IMREAD_UNCHANGED);
        if (pages == 0)
            throw core::InputError(fmt::format("{}: is not a readable picture", name_));
        if (pages == 1)
            throw core::InputError(fmt::format(
                "{}: this TIFF file has one page; of numbered pictures give a pattern like "
                "frames/%05d.tif (ImageJ stores more than 4 GB in one page: save an image "
                "sequence)",
                name_));
        for (std::size_t page = 0; page < pages; ++page)
            numbers_.push_back(static_cast<int>(page));
    }

    /// Blocks of pages, because the library walks from the first page to the wanted one.
    void for_each(std::span<const std::size_t> wanted, int threads, const Use& use) const override {
        constexpr std::size_t block = 32;
        for_each_index((wanted.size() + block - 1) / block, threads, [&](std::size_t k) {
            const std::size_t begin = k * block;
            const std::size_t end = std::min(wanted.size(), begin + block);
            const bool is_dense = wanted[end - 1] - wanted[begin] == end - 1 - begin;
            std::vector<cv::Mat> pages;
            for (std::size_t i = begin; i < end; ++i) {
                if (!is_dense || i == begin) {
                    pages.clear();
                    cv::imreadmulti(name_, pages, static_cast<int>(wanted[i]),
                                    is_dense ? static_cast<int>(end - begin) : 1,
                                    cv::IMREAD_UNCHANGED);
                }
                const std::size_t page = is_dense ? i - begin : 0;
                if (page >= pages.size() || pages[page].empty())
                    throw core::InputError(
                        fmt::format("{}: page {} cannot be read", name_, wanted[i] + 1));
                use(i, frame_from(pages[page], name_));
            }
        });
    }
};

/// A damaged container may state any time; with more lost frames a recording is unusable.
constexpr double most_missing = 1e6;

cv::VideoCapture open(const std::string& file) {
    cv::VideoCapture video(file);
    if (!video.isOpened())
        throw core::InputError(fmt::format("{}: is not a video that OpenCV can read", file));
    return video;
}

/// Any video file that OpenCV reads.
class VideoFile final : public FrameSource {
  public:
    explicit VideoFile(const std::filesystem::path& file) {
        name_ = file.string();
        cv::VideoCapture video = open(name_);
        if (const double fps = video.get(cv::CAP_PROP_FPS); fps > 0.0 && std::isfinite(fps))
            stated_fps_ = fps;
        // The number of frames that a container states is often an estimate.
        while (video.grab()) {
            numbers_.push_back(static_cast<int>(numbers_.size()));
            stamps_.push_back(video.get(cv::CAP_PROP_POS_MSEC));
        }
        if (numbers_.empty())
            throw core::InputError(fmt::format("{}: holds no frame", name_));
        find_missing_frames(stamps_);
    }

    /// A video is decoded in order: the threads decode in turn and track their own frames.
    void for_each(std::span<const std::size_t> wanted, int threads, const Use& use) const override {
        cv::VideoCapture video = open(name_);
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
                    // The decoder uses its buffer again for the next frame, while this one is still
                    // being tracked.
                    picture = decoded.clone();
                }
                try {
                    if (picture.empty())
                        throw core::InputError(
                            fmt::format("{}: frame {} cannot be decoded", name_, wanted[i]));
                    use(i, frame_from(picture, name_));
                } catch (...) {
                    error.keep(i);
                }
            }
        });
        error.rethrow();
    }

  private:
    /// If time stamps skip a frame time, frames were lost: the numbers get a gap.
    void find_missing_frames(const std::vector<double>& stamps) {
        if (stamps.size() < 5)
            return;
        int shift = 0;
        for (std::size_t i = 1; i < stamps.size(); ++i) {
            // A camera that lengthens its frames from some time on loses none.
            const std::size_t begin = i - std::min<std::size_t>(i, 10);
            const double usual = core::median_interval(
                std::span(stamps).subspan(begin, std::min<std::size_t>(21, stamps.size() - begin)));
            if (!(usual > 0.0))
                continue;
            // Containers round time stamps, often to a millisecond.
            const double step = stamps[i] - stamps[i - 1];
            const double skipped = std::round(step / usual) - 1.0;
            if (!(skipped <= most_missing - double(shift)))
                throw core::InputError(fmt::format(
                    "{}: the time stamps skip {:g} frames after frame {}; at most {:g} may be "
                    "missing",
                    name_, skipped, numbers_[i - 1], most_missing));
            const int missing = static_cast<int>(std::max(-1.0, skipped));
            if (missing > 0 && step > 1.5 * usual + 1.0) {
                remarks_.push_back(
                    fmt::format("the time stamps skip {} frame time{} after frame {}", missing,
                                missing == 1 ? "" : "s", numbers_[i - 1]));
                shift += missing;
            }
            numbers_[i] += shift;
        }
    }
};

} // namespace

std::unique_ptr<FrameSource> open_frames(const std::filesystem::path& folder,
                                         const std::string& location) {
    const std::filesystem::path path = folder / location;
    if (path.filename().string().find('%') != std::string::npos)
        return std::make_unique<ImageSequence>(path);
    if (!std::filesystem::is_regular_file(path))
        throw core::InputError(fmt::format(
            "{}: is not a file (a numbered image sequence is written like frames/%05d.png)",
            path.string()));
    const std::string extension = path.extension().string();
    if (extension == ".cih" || extension == ".cihx" || extension == ".CIH" || extension == ".CIHX")
        return open_photron(path);
    if (extension == ".mraw" || extension == ".MRAW")
        throw core::InputError(
            fmt::format("{}: give the header that belongs to it (.cih or .cihx)", path.string()));
    if (extension == ".tif" || extension == ".tiff" || extension == ".TIF" || extension == ".TIFF")
        return std::make_unique<PageStack>(path);
    return std::make_unique<VideoFile>(path);
}

} // namespace culm::measure
