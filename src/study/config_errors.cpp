// SPDX-License-Identifier: BSD-3-Clause
#include "study/config_errors.hpp"

#include "core/error.hpp"

#include <algorithm>

#include <fmt/format.h>

namespace culm::study {

void ConfigErrors::add(std::size_t line, std::string_view text) {
    errors_.push_back({line, fmt::format("{}:{}: {}", file_, line, text)});
}

void ConfigErrors::add(std::size_t line, std::string_view key, std::string_view value,
                       std::string_view allowed) {
    add(line, fmt::format("{} = {}: {}", key, value, allowed));
}

void ConfigErrors::throw_if_any() const {
    if (errors_.empty())
        return;
    auto ordered = errors_;
    std::ranges::stable_sort(ordered, {}, &Error::line);
    std::string text;
    for (const Error& error : ordered)
        text += (text.empty() ? "" : "\n") + error.text;
    throw core::InputError(text);
}

} // namespace culm::study
