// SPDX-License-Identifier: BSD-3-Clause
#include "measure/c3d_file.hpp"

#include "core/file_text.hpp"
#include "measure/c3d_bytes.hpp"
#include "measure/c3d_parameters.hpp"

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

/// A number that counts something; damaged files hold anything.
std::size_t whole(const C3dBytes& bytes, double value) {
    constexpr double largest = 1e9;
    if (!(value >= 0.0 && value <= largest))
        bytes.fail(fmt::format("a count is {:g}", value));
    return static_cast<std::size_t>(value);
}

/// The header counts frames in 16 bits; longer recordings say it in one of several places.
std::size_t frame_count(const C3dBytes& bytes, const C3dParameters& parameters) {
    const std::size_t first = bytes.word(6);
    const std::size_t last = bytes.word(8);
    std::size_t frames = last >= first ? last - first + 1 : 0;
    const bool is_capped = last == 65535;
    if (const auto stated = number(parameters, "POINT:FRAMES"); stated && *stated > double(frames))
        frames = whole(bytes, *stated);
    if (const auto stated = number(parameters, "POINT:LONG_FRAMES"); stated && *stated > 0.0)
        frames = whole(bytes, *stated);
    // TRIAL:ACTUAL_…_FIELD hold 32 bits in two words, low word first.
    const auto begin = parameters.find("TRIAL:ACTUAL_START_FIELD");
    const auto end = parameters.find("TRIAL:ACTUAL_END_FIELD");
    if (is_capped && begin != parameters.end() && end != parameters.end() &&
        begin->second.numbers.size() == 2 && end->second.numbers.size() == 2) {
        const auto field = [&](const std::vector<double>& words) {
            return whole(bytes, words[0] + 65536.0 * words[1]);
        };
        if (field(end->second.numbers) >= field(begin->second.numbers))
            frames = field(end->second.numbers) - field(begin->second.numbers) + 1;
    }
    return frames;
}

PointLayout read_layout(const C3dBytes& bytes, const C3dParameters& parameters) {
    PointLayout layout;
    layout.markers =
        static_cast<std::size_t>(number(parameters, "POINT:USED").value_or(double(bytes.word(2))));
    layout.analog_words = bytes.word(4);
    layout.scale = number(parameters, "POINT:SCALE").value_or(bytes.real(12));
    const std::size_t first_block =
        whole(bytes, number(parameters, "POINT:DATA_START").value_or(double(bytes.word(16))));
    layout.frames = frame_count(bytes, parameters);
    if (layout.markers == 0 || layout.frames == 0)
        bytes.fail("it holds no markers");
    if (first_block < 2)
        bytes.fail(fmt::format("its points begin in block {}", first_block));
    layout.begin = (first_block - 1) * block;
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
    if (!(tracks.frames_per_second > 0.0))
        bytes.fail("it does not say its frame rate");
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
