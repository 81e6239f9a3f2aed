// SPDX-License-Identifier: BSD-3-Clause
// Colours of text on a terminal.
#pragma once

#include <string>
#include <string_view>

#include <fmt/color.h>

namespace culm::present {

/// Highlights texts by colour. Without colours it returns every text unchanged, so that pipes and
/// files never contain escape sequences.
class TextStyle {
  public:
    explicit TextStyle(bool is_coloured = false) : is_coloured_(is_coloured) {}

    [[nodiscard]] std::string good(std::string_view text) const {
        return styled(fmt::fg(fmt::terminal_color::green), text);
    }
    [[nodiscard]] std::string warning(std::string_view text) const {
        return styled(fmt::fg(fmt::terminal_color::yellow), text);
    }
    [[nodiscard]] std::string failure(std::string_view text) const {
        return styled(fmt::fg(fmt::terminal_color::red), text);
    }

    /// Everything up to the first colon bold: "EFFECT: …".
    [[nodiscard]] std::string headline(std::string_view text) const {
        const std::size_t end = text.find(':') + 1; // 0: there is no colon
        return end == 0 ? std::string(text)
                        : styled(fmt::emphasis::bold, text.substr(0, end)) +
                              std::string(text.substr(end));
    }

  private:
    [[nodiscard]] std::string styled(const fmt::text_style& style, std::string_view text) const {
        return is_coloured_ ? fmt::format(style, "{}", text) : std::string(text);
    }

    bool is_coloured_;
};

} // namespace culm::present
