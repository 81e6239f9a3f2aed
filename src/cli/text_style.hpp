// SPDX-License-Identifier: BSD-3-Clause
// Colours of what a person reads on a terminal, and messages on standard error.
#pragma once

#include <cstdio>
#include <string>
#include <string_view>

namespace culm::cli {

/// How texts are set off. Made for a stream, it colours only if that is a terminal, no launcher
/// started the process, TERM is set and not "dumb", and NO_COLOR is not set
/// (https://no-color.org); else every text stays as it is, so
/// that pipes and files never hold escape sequences.
class TextStyle {
  public:
    TextStyle() = default; ///< colours nothing
    [[nodiscard]] static TextStyle of(std::FILE* stream);

    [[nodiscard]] std::string verdict(std::string_view text) const; ///< bold
    [[nodiscard]] std::string good(std::string_view text) const;    ///< green
    [[nodiscard]] std::string warning(std::string_view text) const; ///< yellow
    [[nodiscard]] std::string failure(std::string_view text) const; ///< red

    /// Everything up to the first colon bold: "EFFECT: …".
    [[nodiscard]] std::string headline(std::string_view text) const;
    /// A model's finding in its colour: "fits" good, "something is missing" a warning, "failed" a
    /// failure; any other stays as it is.
    [[nodiscard]] std::string finding(std::string_view text) const;

  private:
    bool is_coloured_ = false;
};

/// "culm: reason" on standard error, `culm:` red on a terminal.
void print_error(std::string_view reason);

/// "culm: note: text" and "culm: warning: text" on standard error, the second word yellow on a
/// terminal.
void print_note(std::string_view text);
void print_warning(std::string_view text);

} // namespace culm::cli
