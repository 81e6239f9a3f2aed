// SPDX-License-Identifier: BSD-3-Clause
// The values of one factor: a list, a range or a distribution.
#pragma once

#include "study/config_context.hpp"
#include "study/config_reader.hpp"
#include "study/factor.hpp"

#include <optional>
#include <string>

namespace culm::study {

/// The factor of one entry of [factors], or nothing with the errors recorded.
[[nodiscard]] std::optional<Factor> read_factor(const TableEntry& entry, const Parameter& parameter,
                                                ConfigContext& context);

/// The value in SI if the node is a number that the parameter allows.
[[nodiscard]] std::optional<double> parameter_value(const toml::node& node,
                                                    const Parameter& parameter);

/// What the parameter's values must be, for messages: "must be a number in (0, 1000] mm".
[[nodiscard]] std::string parameter_allowed(const Parameter& parameter);

} // namespace culm::study
