// SPDX-License-Identifier: BSD-3-Clause
#include "measure/c3d_parameters.hpp"

#include <algorithm>
#include <cctype>
#include <cstdlib>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace culm::measure {

namespace {

std::string capitals(std::string text) {
    std::ranges::transform(text, text.begin(),
                           [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
    return text;
}

/// The header of the section counts its blocks of 512 bytes in one byte. Some programs write a
/// wrong count there, so the largest one bounds the section.
constexpr std::size_t largest_section = std::size_t{255} * 512;

/// What precedes the content of a group or a parameter.
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
/// bytes are refused before they are read: if entries overlapped, the memory they need would grow
/// with the square of the file's size.
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
    // The first dimension is the length of each text; texts without letters are none.
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

} // namespace

C3dParameters read_c3d_parameters(C3dBytes& bytes, std::size_t begin) {
    const int processor = bytes.byte(begin + 3);
    if (processor < 84 || processor > 86)
        bytes.fail(fmt::format("processor type {} (84 Intel, 85 DEC, 86 MIPS)", processor));
    bytes.set_processor(static_cast<C3dProcessor>(processor));
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

} // namespace culm::measure
