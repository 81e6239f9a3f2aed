// SPDX-License-Identifier: BSD-3-Clause
// Finds the valid name nearest to a mistyped one.
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace culm::core {

/// Levenshtein distance: insertions, deletions and substitutions that turn `a` into `b`.
[[nodiscard]] std::size_t edit_distance(std::string_view a, std::string_view b);

/// The candidate that `name` probably means: a known synonym, a name that differs by one letter,
/// one that has `name` among its words ("drag"), or the nearest by edit distance; the first of
/// equals. Empty when more than half of the letters would have to change.
[[nodiscard]] std::string nearest_name(std::string_view name, std::span<const std::string> valid);

/// " (did you mean X?)" with the nearest name between the quotes given, or an empty text.
[[nodiscard]] std::string did_you_mean(std::string_view name, std::span<const std::string> valid,
                                       std::string_view quote = "\"");

} // namespace culm::core
