// SPDX-License-Identifier: BSD-3-Clause
// One factor's inline table while it is read.
#pragma once

#include "study/config_context.hpp"
#include "study/config_factor_values.hpp"
#include "study/config_reader.hpp"
#include "study/factor.hpp"

#include <array>
#include <optional>
#include <string>
#include <string_view>

namespace culm::study {

inline constexpr std::array<std::string_view, 5> range_keys{"from", "to", "step", "count",
                                                            "spacing"};
inline constexpr std::array<std::string_view, 10> distribution_keys{
    "mean", "sd", "min", "max", "file", "column", "unit", "rows", "level", "within_sd"};

struct FactorTable {
    TableReader reader;
    const Parameter& parameter;
    ConfigContext& context;

    /// A number of the table that must be one of the parameter's values; in the parameter's unit.
    [[nodiscard]] std::optional<double> value(std::string_view key) const {
        const auto number = reader.number(key);
        if (!number || parameter.range.contains(*number))
            return number;
        reader.error(key, parameter_allowed(parameter));
        return std::nullopt;
    }
    void need(std::string_view key, const std::string& who) const {
        if (!reader.has(key))
            reader.error(key, who + " needs it");
    }
    template <class Keys>
    void refuse(const Keys& keys, const std::string& reason) const {
        for (const std::string_view key : keys)
            if (reader.has(key))
                reader.error(key, reason);
    }
};

/// A factor with the key `distribution`, or nothing with the errors recorded.
[[nodiscard]] std::optional<Factor> read_distribution(const FactorTable& table);

} // namespace culm::study
