// SPDX-License-Identifier: BSD-3-Clause
#include "cli/options.hpp"

#include <cstdlib>

#include <fmt/core.h>

namespace culm::cli {

CLI::Validator number_in(const study::Interval& range) {
    const auto complaint = [range](const std::string& text) {
        char* end = nullptr;
        const double value = std::strtod(text.c_str(), &end);
        const bool is_number = end != text.c_str() && *end == '\0';
        return is_number && range.contains(value)
                   ? std::string()
                   : fmt::format("{} is not a number in {}", text, range.text());
    };
    return {complaint, "in " + range.text()};
}

} // namespace culm::cli
