// SPDX-License-Identifier: BSD-3-Clause
// Numbers in a C3D file, whichever of three processors wrote them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

namespace culm::measure {

/// The fourth byte of the parameter section.
enum class C3dProcessor : std::uint8_t { Intel = 84, Dec = 85, Mips = 86 };

/// Bytes of a whole file with checked access.
class C3dBytes {
  public:
    C3dBytes(std::string content, std::string file)
        : content_(std::move(content)), file_(std::move(file)) {}

    void set_processor(C3dProcessor processor) { processor_ = processor; }
    [[nodiscard]] std::size_t size() const { return content_.size(); }

    /// Each throws core::InputError where the file ends before the number does.
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
    C3dProcessor processor_ = C3dProcessor::Intel;
};

} // namespace culm::measure
