// SPDX-License-Identifier: BSD-3-Clause
#include "core/error.hpp"
#include "core/user_files.hpp"
#include "measure/import/recorded_series.hpp"

#include <algorithm>
#include <bit>
#include <cctype>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace culm::measure {

namespace {

constexpr int intel = 84; ///< the fourth byte of the parameter section: the order of bytes

/// Bytes of a whole file with checked access.
class C3dBytes {
  public:
    C3dBytes(std::string content, std::string file)
        : content_(std::move(content)), file_(std::move(file)) {}

    [[nodiscard]] std::size_t size() const { return content_.size(); }

    /// Each throws core::InputError if the file ends before the end of the number.
    [[nodiscard]] std::uint8_t byte(std::size_t offset) const;
    [[nodiscard]] int signed_byte(std::size_t offset) const;
    [[nodiscard]] std::uint16_t word(std::size_t offset) const;
    [[nodiscard]] std::int16_t signed_word(std::size_t offset) const;
    [[nodiscard]] double real(std::size_t offset) const;
    [[nodiscard]] std::string text(std::size_t offset, std::size_t length) const;

    /// Throws core::InputError "FILE: not a C3D file that can be read: text".
    [[noreturn]] void fail(const std::string& text) const;

  private:
    void check(std::size_t offset, std::size_t length) const;

    std::string content_;
    std::string file_;
};

std::uint8_t C3dBytes::byte(std::size_t offset) const {
    check(offset, 1);
    return static_cast<std::uint8_t>(content_[offset]);
}

int C3dBytes::signed_byte(std::size_t offset) const {
    const int value = byte(offset);
    return value < 128 ? value : value - 256;
}

std::uint16_t C3dBytes::word(std::size_t offset) const {
    const unsigned first = byte(offset);
    const unsigned second = byte(offset + 1);
    return static_cast<std::uint16_t>(second << 8U | first);
}

std::int16_t C3dBytes::signed_word(std::size_t offset) const {
    return static_cast<std::int16_t>(word(offset));
}

double C3dBytes::real(std::size_t offset) const {
    const std::uint32_t first = word(offset);
    const std::uint32_t second = word(offset + 2);
    return static_cast<double>(std::bit_cast<float>(second << 16U | first));
}

std::string C3dBytes::text(std::size_t offset, std::size_t length) const {
    check(offset, length);
    std::string text = content_.substr(offset, length);
    const std::size_t end = text.find_last_not_of(std::string(" \0", 2));
    return end == std::string::npos ? std::string() : text.substr(0, end + 1);
}

void C3dBytes::fail(const std::string& text) const {
    throw core::InputError(fmt::format("{}: not a C3D file that can be read: {}", file_, text));
}

void C3dBytes::check(std::size_t offset, std::size_t length) const {
    if (offset + length > content_.size())
        fail(fmt::format("it ends after {} bytes, data was expected at byte {}", content_.size(),
                         offset));
}

struct C3dParameter {
    std::vector<double> numbers;    ///< of byte, integer and real parameters, in the file's order
    std::vector<std::string> texts; ///< of character parameters
};

/// "GROUP:NAME" in capitals -> values.
using C3dParameters = std::map<std::string, C3dParameter>;

std::string capitals(std::string text) {
    std::ranges::transform(text, text.begin(),
                           [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
    return text;
}

/// The section's header counts its blocks of 512 bytes in one byte. Some programs write a wrong
/// count, so the section is limited by the largest possible count.
constexpr std::size_t largest_section = std::size_t{255} * 512;

/// Header of a group or a parameter.
struct Entry {
    std::size_t begin = 0;
    std::size_t name_length = 0;
    int group = 0; ///< negative: the definition of the group −group
    std::string name;
    std::size_t after_name = 0; ///< position of the offset to the next entry
};

Entry read_entry(const C3dBytes& bytes, std::size_t at) {
    Entry entry;
    entry.begin = at;
    // The length is negative for locked parameters.
    entry.name_length = static_cast<std::size_t>(std::abs(bytes.signed_byte(at)));
    entry.group = bytes.signed_byte(at + 1);
    entry.name = capitals(bytes.text(at + 2, entry.name_length));
    entry.after_name = at + 2 + entry.name_length;
    return entry;
}

/// Product of the dimensions. Elements of `size` bytes that do not fit into the entry's `room`
/// bytes are refused before they are read; overlapping entries would need memory proportional to
/// the square of the file's size.
std::size_t element_count(const C3dBytes& bytes, const Entry& entry,
                          const std::vector<std::size_t>& dimensions, std::size_t size,
                          std::size_t room) {
    if (std::ranges::find(dimensions, std::size_t{0}) != dimensions.end())
        return 0;
    std::size_t count = 1;
    for (const std::size_t dimension : dimensions) {
        count *= dimension;
        if (count * size > room)
            bytes.fail(fmt::format("parameter {} at byte {} = {} elements of {} bytes: its entry "
                                   "ends after {} bytes",
                                   entry.name, entry.begin, fmt::join(dimensions, " x "), size,
                                   room));
    }
    return count;
}

std::vector<std::string> read_texts(const C3dBytes& bytes, const Entry& entry, std::size_t at,
                                    const std::vector<std::size_t>& dimensions, std::size_t room) {
    // The first dimension is the length of each text; a length of 0 means no texts.
    const std::size_t length = dimensions.empty() ? 1 : dimensions.front();
    const std::size_t letters = element_count(bytes, entry, dimensions, 1, room);
    const std::size_t count = length == 0 ? 0 : letters / length;
    std::vector<std::string> texts;
    for (std::size_t i = 0; i < count; ++i)
        texts.push_back(bytes.text(at + i * length, length));
    return texts;
}

/// `end` is where the next entry begins, or where the section ends.
C3dParameter read_parameter(const C3dBytes& bytes, const Entry& entry, std::size_t end) {
    std::size_t at = entry.after_name + 2;
    const int type = bytes.signed_byte(at++);
    const std::size_t dimension_count = bytes.byte(at++);
    std::vector<std::size_t> dimensions;
    for (std::size_t i = 0; i < dimension_count; ++i)
        dimensions.push_back(bytes.byte(at++));
    const std::size_t room = end > at ? end - at : 0;
    C3dParameter parameter;
    if (type == -1) {
        parameter.texts = read_texts(bytes, entry, at, dimensions, room);
        return parameter;
    }
    if (type != 1 && type != 2 && type != 4)
        bytes.fail(fmt::format("parameter {} has the type {}: must be -1 (text), 1 (byte), 2 "
                               "(integer) or 4 (real)",
                               entry.name, type));
    const std::size_t count =
        element_count(bytes, entry, dimensions, static_cast<std::size_t>(type), room);
    for (std::size_t i = 0; i < count; ++i) {
        const std::size_t place = at + i * static_cast<std::size_t>(type);
        parameter.numbers.push_back(type == 1   ? double(bytes.byte(place))
                                    : type == 2 ? double(bytes.word(place))
                                                : bytes.real(place));
    }
    return parameter;
}

/// Reads the section that begins at byte `begin`.
C3dParameters read_c3d_parameters(const C3dBytes& bytes, std::size_t begin) {
    if (const int processor = bytes.byte(begin + 3); processor != intel)
        bytes.fail(fmt::format("processor type {}; only files of type {} (Intel) are read",
                               processor, intel));
    std::map<int, std::string> groups;
    std::vector<std::pair<Entry, C3dParameter>> found;
    std::size_t at = begin + 4;
    const std::size_t section_end = std::min(bytes.size(), begin + largest_section);
    while (at + 2 <= section_end) {
        const Entry entry = read_entry(bytes, at);
        if (entry.name_length == 0 || entry.group == 0)
            break;
        const std::size_t offset = bytes.word(entry.after_name);
        const std::size_t end = offset == 0 ? section_end : entry.after_name + offset;
        if (entry.group < 0)
            groups[-entry.group] = entry.name;
        else
            found.emplace_back(entry, read_parameter(bytes, entry, std::min(end, section_end)));
        if (offset == 0)
            break;
        at = entry.after_name + offset;
    }
    C3dParameters parameters;
    for (auto& [entry, parameter] : found)
        parameters[groups[entry.group] + ":" + entry.name] = std::move(parameter);
    return parameters;
}

constexpr std::size_t block = 512;

/// Position and coding of the points.
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

/// A whole number from `key`, which may be damaged or hostile. The value is a double because the
/// parameter may be stored as one.
std::size_t whole(const C3dBytes& bytes, const std::string& key, double value, double lowest,
                  double highest) {
    if (!(value >= lowest && value <= highest) || value != std::floor(value))
        bytes.fail(fmt::format("{} = {}: must be a whole number from {} to {}", key, value, lowest,
                               highest));
    return static_cast<std::size_t>(value);
}

/// A parameter, or the header field that replaces it.
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
constexpr std::size_t whole_blocks = core::largest_recording / block;
constexpr double most_blocks = double(whole_blocks);

/// The header counts frames in 16 bits; longer recordings use one of several parameters.
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
    // TRIAL:ACTUAL_…_FIELD contain 32 bits in two words, low word first.
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
