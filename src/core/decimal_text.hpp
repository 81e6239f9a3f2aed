// SPDX-License-Identifier: BSD-3-Clause
// Decimal numbers as text, converted between units by moving the decimal point.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace culm::core {

/// The double nearest to text · 10^power_of_ten; empty unless the whole text is one finite decimal
/// number. The point is moved in the text, so 0.1820 in mm is exactly the double 1.82e-4.
[[nodiscard]] std::optional<double> parse_decimal(std::string_view text, int power_of_ten = 0);

/// The shortest decimal text of value · 10^power_of_ten that parse_decimal converts to `value` bit
/// for bit (with the opposite power); without an exponent for 1e-7 … 1e16.
[[nodiscard]] std::string decimal_text(double value, int power_of_ten = 0);

/// value · 10^power_of_ten, correctly rounded from the shortest decimal number that identifies
/// `value`; for numbers that another parser has read.
[[nodiscard]] double with_point_moved(double value, int power_of_ten);

} // namespace culm::core
