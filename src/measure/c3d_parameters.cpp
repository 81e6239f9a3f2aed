// SPDX-License-Identifier: BSD-3-Clause
#include "measure/c3d_parameters.hpp"

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <span>

#include <fmt/format.h>

namespace culm::measure {

namespace {

std::string capitals(std::string text) {
    std::ranges::transform(text, text.begin(),
                           [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
    return text;
}

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

/// Product of dimensions; more elements than the file has bytes are refused before they are read.
std::size_t element_count(const C3dBytes& bytes, std::span<const std::size_t> dimensions) {
    std::size_t count = 1;
    for (const std::size_t dimension : dimensions) {
        count *= dimension;
        if (count > bytes.size())
            bytes.fail("a parameter has more elements than the file has bytes");
    }
    return count;
}

std::vector<std::string> read_texts(const C3dBytes& bytes, std::size_t at,
                                    const std::vector<std::size_t>& dimensions) {
    // The first dimension is the length of each text.
    const std::size_t length = dimensions.empty() ? 1 : dimensions.front();
    const std::size_t count =
        dimensions.empty() ? 1 : element_count(bytes, std::span(dimensions).subspan(1));
    std::vector<std::string> texts;
    for (std::size_t i = 0; i < count; ++i)
        texts.push_back(bytes.text(at + i * length, length));
    return texts;
}

C3dParameter read_parameter(const C3dBytes& bytes, const Entry& entry) {
    std::size_t at = entry.after_name + 2;
    const int type = bytes.signed_byte(at++);
    const std::size_t dimension_count = bytes.byte(at++);
    std::vector<std::size_t> dimensions;
    for (std::size_t i = 0; i < dimension_count; ++i)
        dimensions.push_back(bytes.byte(at++));
    C3dParameter parameter;
    if (type == -1) {
        parameter.texts = read_texts(bytes, at, dimensions);
        return parameter;
    }
    if (type != 1 && type != 2 && type != 4)
        bytes.fail(fmt::format("parameter {} has the type {}", entry.name, type));
    const std::size_t count = element_count(bytes, dimensions);
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
    while (at + 2 <= bytes.size()) {
        const Entry entry = read_entry(bytes, at);
        if (entry.name_length == 0 || entry.group == 0)
            break;
        if (entry.group < 0)
            groups[-entry.group] = entry.name;
        else
            found.emplace_back(entry, read_parameter(bytes, entry));
        const std::size_t offset = bytes.word(entry.after_name);
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
