// SPDX-License-Identifier: BSD-3-Clause
#include "core/nearest_name.hpp"

#include <algorithm>
#include <numeric>
#include <utility>
#include <vector>

#include <fmt/core.h>

namespace culm::core {

/// The table of Wagner & Fischer (1974), of which one row is kept; `diagonal` is the entry of the
/// previous row to the left.
std::size_t edit_distance(std::string_view a, std::string_view b) {
    std::vector<std::size_t> row(b.size() + 1);
    std::iota(row.begin(), row.end(), std::size_t{0});
    for (std::size_t i = 1; i <= a.size(); ++i) {
        std::size_t diagonal = row[0];
        row[0] = i;
        for (std::size_t j = 1; j <= b.size(); ++j) {
            const std::size_t substitution = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
            diagonal = row[j];
            row[j] = std::min({row[j] + 1, row[j - 1] + 1, substitution});
        }
    }
    return row[b.size()];
}

namespace {

/// Abbreviations, symbols of the literature and former names, for names of culm.
constexpr std::pair<std::string_view, std::string_view> synonyms[] = {
    {"lhs", "latin_hypercube"}, {"beta", "bond_damping"}, {"damping", "bond_damping"},
    {"cd", "drag_coefficient"}, {"verlet", "explicit"},   {"correlation", "factors"},
};

/// Whether `name` is one or more of the words of `candidate`, which underscores separate.
bool is_part(std::string_view name, std::string_view candidate) {
    return fmt::format("_{}_", candidate).find(fmt::format("_{}_", name)) != std::string::npos;
}

} // namespace

std::string nearest_name(std::string_view name, std::span<const std::string> valid) {
    for (const auto& [synonym, meant] : synonyms)
        if (name == synonym && std::ranges::find(valid, meant) != valid.end())
            return std::string(meant);
    // A typing error of one letter is more probable than an omitted word.
    for (const std::string& candidate : valid)
        if (edit_distance(name, candidate) <= 1)
            return candidate;
    for (const std::string& candidate : valid)
        if (is_part(name, candidate))
            return candidate;
    // At least half of the letters must agree. Two letters may always differ: in short names a
    // single transposition counts twice.
    const std::size_t most = std::max<std::size_t>(2, name.size() / 2);
    const auto distance = [&](const std::string& word) { return edit_distance(name, word); };
    const auto best = std::ranges::min_element(valid, {}, distance);
    return best != valid.end() && distance(*best) <= most ? *best : "";
}

std::string did_you_mean(std::string_view name, std::span<const std::string> valid,
                         std::string_view quote) {
    const std::string nearest = nearest_name(name, valid);
    return nearest.empty() ? "" : fmt::format(" (did you mean {0}{1}{0}?)", quote, nearest);
}

} // namespace culm::core
