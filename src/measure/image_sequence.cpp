// SPDX-License-Identifier: BSD-3-Clause
#include "core/error.hpp"
#include "measure/frame_from_opencv.hpp"
#include "measure/parallel_frames.hpp"
#include "measure/picture_files.hpp"

#include <algorithm>
#include <charconv>
#include <string_view>

#include <fmt/core.h>
#include <opencv2/imgcodecs.hpp>

namespace culm::measure {
namespace {

/// As in video.toml. Numbers grow by those of missing frames, and must stay an int.
constexpr int largest_frame_number = 1'000'000'000;

/// A file name with a place for the frame's number.
struct NumberedName {
    std::string before;
    std::string after;
    std::size_t digits = 1; ///< padded with zeros to so many at least

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

class ImageSequence final : public FrameSource {
  public:
    explicit ImageSequence(const std::filesystem::path& pattern)
        : pattern_(pattern.string()), folder_(pattern.parent_path()),
          name_(parse_name(pattern.filename().string(), pattern_)) {
        std::error_code error;
        for (const auto& entry : std::filesystem::directory_iterator(folder_, error))
            if (const int number = name_.number_in(entry.path().filename().string()); number >= 0)
                numbers_.push_back(number);
        if (error)
            throw core::InputError(
                fmt::format("{}: cannot be read: {}", folder_.string(), error.message()));
        if (numbers_.empty())
            throw core::InputError(fmt::format("{}: no file has a name of this form", pattern_));
        std::ranges::sort(numbers_);
    }

    [[nodiscard]] const std::vector<int>& numbers() const override { return numbers_; }
    [[nodiscard]] std::string name() const override { return pattern_; }

    void for_each(std::span<const std::size_t> wanted, int threads, const Use& use) const override {
        for_each_index(wanted.size(), threads, [&](std::size_t i) {
            const std::string file = (folder_ / name_.file(numbers_.at(wanted[i]))).string();
            const cv::Mat picture = cv::imread(file, cv::IMREAD_UNCHANGED);
            if (picture.empty())
                throw core::InputError(fmt::format("{}: is not a readable picture", file));
            use(i, frame_from(picture, file));
        });
    }

  private:
    std::string pattern_;
    std::filesystem::path folder_;
    NumberedName name_;
    std::vector<int> numbers_;
};

} // namespace

std::unique_ptr<FrameSource> open_image_sequence(const std::filesystem::path& pattern) {
    return std::make_unique<ImageSequence>(pattern);
}

} // namespace culm::measure
