// SPDX-License-Identifier: BSD-3-Clause
#include "measure/c3d_file.hpp"

#include "core/file_text.hpp"
#include "measure/c3d_bytes.hpp"
#include "measure/c3d_parameters.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include <fmt/format.h>

namespace culm::measure {

namespace {

constexpr std::size_t block = 512;

/// Where the points lie and how they are coded.
struct PointLayout {
    std::size_t begin = 0;
    std::size_t markers = 0;
    std::size_t analog_words = 0; ///< per frame, after the points
    std::size_t frames = 0;
    double scale = 0.0; ///< negative: coordinates are floats

    [[nodiscard]] bool is_real() const { return scale < 0.0; }
    [[nodiscard]] std::size_t word_size() const { return is_real() ? 4 : 2; }
    [[nodiscard]] std::size_t frame_size() const {
        return (4 * markers + analog_words) * word_size();
    }
};

std::optional<double> number(const C3dParameters& parameters, const std::string& name) {
    const auto found = parameters.find(name);
    if (found == parameters.end() || found->second.numbers.empty())
        return std::nullopt;
    return found->second.numbers.front();
}

/// A number that counts something, from `key`; damaged and hostile files hold anything. The value
/// is a double because the parameter may be stored as one.
std::size_t whole(const C3dBytes& bytes, const std::string& key, double value, double lowest,
                  double highest) {
    if (!(value >= lowest && value <= highest) || value != std::floor(value))
        bytes.fail(fmt::format("{} = {}: must be a whole number from {} to {}", key, value, lowest,
                               highest));
    return static_cast<std::size_t>(value);
}

/// A parameter, or what stands in its place in the header.
struct Stated {
    std::string key;
    double value = 0.0;
};

Stated stated(const C3dParameters& parameters, const std::string& key, const char* header_key,
              double header_value) {
    const auto value = number(parameters, key);
    return value ? Stated{key, *value} : Stated{header_key, header_value};
}

constexpr double most_frames = 1e9;
constexpr double most_blocks = double(core::largest_recording / block);

/// The header counts frames in 16 bits; longer recordings say it in one of several places.
Stated frame_count(const C3dBytes& bytes, const C3dParameters& parameters) {
    const std::size_t first = bytes.word(6);
    const std::size_t last = bytes.word(8);
    Stated frames{"the header's last - first frame + 1",
                  last >= first ? double(last - first + 1) : 0.0};
    const bool is_capped = last == 65535;
    if (const auto count = number(parameters, "POINT:FRAMES"); count && *count > frames.value)
        frames = {"POINT:FRAMES", *count};
    if (const auto count = number(parameters, "POINT:LONG_FRAMES"); count && *count > 0.0)
        frames = {"POINT:LONG_FRAMES", *count};
    // TRIAL:ACTUAL_…_FIELD hold 32 bits in two words, low word first.
    const auto begin = parameters.find("TRIAL:ACTUAL_START_FIELD");
    const auto end = parameters.find("TRIAL:ACTUAL_END_FIELD");
    if (is_capped && begin != parameters.end() && end != parameters.end() &&
        begin->second.numbers.size() == 2 && end->second.numbers.size() == 2) {
        const auto field = [](const std::vector<double>& words) {
            return words[0] + 65536.0 * words[1];
        };
        const double from = field(begin->second.numbers);
        const double to = field(end->second.numbers);
        if (to >= from)
            frames = {"TRIAL:ACTUAL_END_FIELD - ACTUAL_START_FIELD + 1", to - from + 1.0};
    }
    return frames;
}

PointLayout read_layout(const C3dBytes& bytes, const C3dParameters& parameters) {
    PointLayout layout;
    const Stated used =
        stated(parameters, "POINT:USED", "the header's number of markers", double(bytes.word(2)));
    const Stated start = stated(parameters, "POINT:DATA_START", "the header's first data block",
                                double(bytes.word(16)));
    const Stated scale = stated(parameters, "POINT:SCALE", "the header's scale", bytes.real(12));
    const Stated frames = frame_count(bytes, parameters);
    layout.scale = scale.value;
    if (!std::isfinite(layout.scale))
        bytes.fail(fmt::format("{} = {}: must be a number", scale.key, scale.value));
    if (used.value == 0.0 || frames.value == 0.0)
        bytes.fail("it holds no markers");
    // The format counts markers in 16 bits.
    layout.markers = whole(bytes, used.key, used.value, 1.0, 65535.0);
    layout.analog_words = bytes.word(4);
    layout.frames = whole(bytes, frames.key, frames.value, 1.0, most_frames);
    layout.begin = (whole(bytes, start.key, start.value, 2.0, most_blocks) - 1) * block;
    // At most 1e9 frames of 1.3 MB: 64 bits hold the product.
    const std::size_t needed = layout.begin + layout.frames * layout.frame_size();
    if (bytes.size() < needed)
        bytes.fail(fmt::format("{} frames of {} markers need {} bytes, the file has {}",
                               layout.frames, layout.markers, needed, bytes.size()));
    return layout;
}

void read_point(const C3dBytes& bytes, const PointLayout& layout, std::size_t at,
                double* position) {
    const std::size_t size = layout.word_size();
    const double residual =
        layout.is_real() ? bytes.real(at + 3 * size) : double(bytes.signed_word(at + 3 * size));
    for (std::size_t axis = 0; axis < 3; ++axis) {
        position[axis] = layout.is_real()
                             ? bytes.real(at + axis * size)
                             : layout.scale * double(bytes.signed_word(at + axis * size));
        // A negative residual marks a point that was not seen.
        if (residual < 0.0)
            position[axis] = std::numeric_limits<double>::quiet_NaN();
    }
}

std::vector<std::string> read_labels(const C3dParameters& parameters, std::size_t markers) {
    std::vector<std::string> labels;
    for (const char* name : {"POINT:LABELS", "POINT:LABELS2", "POINT:LABELS3"})
        if (const auto found = parameters.find(name); found != parameters.end())
            labels.insert(labels.end(), found->second.texts.begin(), found->second.texts.end());
    while (labels.size() < markers)
        labels.push_back(fmt::format("marker {}", labels.size() + 1));
    labels.resize(markers);
    return labels;
}

} // namespace

C3dTracks read_c3d(const std::filesystem::path& file) {
    C3dBytes bytes(core::file_text(file, core::largest_recording), file.string());
    if (bytes.size() < block || bytes.byte(1) != 0x50 || bytes.byte(0) < 2)
        bytes.fail("its first two bytes are not those of a C3D file");
    const C3dParameters parameters =
        read_c3d_parameters(bytes, (bytes.byte(0) - std::size_t{1}) * block);
    const PointLayout layout = read_layout(bytes, parameters);
    C3dTracks tracks;
    tracks.frames_per_second = number(parameters, "POINT:RATE").value_or(bytes.real(20));
    if (!(tracks.frames_per_second > 0.0) || !std::isfinite(tracks.frames_per_second))
        bytes.fail(fmt::format("POINT:RATE = {}: must be the number of frames per second, above 0",
                               tracks.frames_per_second));
    if (const auto units = parameters.find("POINT:UNITS");
        units != parameters.end() && !units->second.texts.empty())
        tracks.unit = units->second.texts.front();
    tracks.labels = read_labels(parameters, layout.markers);
    tracks.frames = layout.frames;
    tracks.positions.resize(layout.frames * layout.markers * 3);
    for (std::size_t i = 0; i < layout.frames; ++i)
        for (std::size_t k = 0; k < layout.markers; ++k)
            read_point(bytes, layout,
                       layout.begin + i * layout.frame_size() + 4 * k * layout.word_size(),
                       &tracks.positions[(i * layout.markers + k) * 3]);
    return tracks;
}

} // namespace culm::measure
