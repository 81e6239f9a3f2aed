// SPDX-License-Identifier: BSD-3-Clause
#include "core/file_faults.hpp"

#include "core/error.hpp"

#include <algorithm>

#include <fmt/format.h>

namespace culm::core {

void FileFaults::add(std::size_t line, std::string_view text) {
    faults_.push_back({line, line == 0 ? fmt::format("{}: {}", file_, text)
                                       : fmt::format("{}:{}: {}", file_, line, text)});
}

void FileFaults::add(std::size_t line, std::string_view key, std::string_view value,
                     std::string_view allowed) {
    add(line, fmt::format("{} = {}: {}", key, value, allowed));
}

void FileFaults::throw_if_any() const {
    if (faults_.empty())
        return;
    constexpr std::size_t most_listed = 12;
    // Readers find faults key by key, a person mends a file from top to bottom. The sort is stable:
    // faults of one line stay in the order in which they were found.
    auto ordered = faults_;
    std::ranges::stable_sort(ordered, {}, &Fault::line);
    std::string text;
    for (std::size_t i = 0; i < std::min(ordered.size(), most_listed); ++i)
        text += (i == 0 ? "" : "\n") + ordered[i].text;
    if (ordered.size() > most_listed)
        text += fmt::format("\n... and {} more faults in {}", ordered.size() - most_listed, file_);
    throw InputError(text);
}

} // namespace culm::core
