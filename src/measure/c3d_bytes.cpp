// SPDX-License-Identifier: BSD-3-Clause
#include "measure/c3d_bytes.hpp"

#include "core/error.hpp"

#include <bit>

#include <fmt/format.h>

namespace culm::measure {

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
    return static_cast<std::uint16_t>(processor_ == C3dProcessor::Mips ? first << 8U | second
                                                                       : second << 8U | first);
}

std::int16_t C3dBytes::signed_word(std::size_t offset) const {
    return static_cast<std::int16_t>(word(offset));
}

double C3dBytes::real(std::size_t offset) const {
    const std::uint32_t first = word(offset);
    const std::uint32_t second = word(offset + 2);
    // Intel: low word first. MIPS and DEC: high word first; a DEC number has the layout of IEEE
    // with an exponent that is larger by 2 (VAX F format).
    const bool low_first = processor_ == C3dProcessor::Intel;
    const std::uint32_t bits = low_first ? second << 16U | first : first << 16U | second;
    const auto value = static_cast<double>(std::bit_cast<float>(bits));
    return processor_ == C3dProcessor::Dec ? 0.25 * value : value;
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

} // namespace culm::measure
