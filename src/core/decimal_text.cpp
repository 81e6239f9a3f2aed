// SPDX-License-Identifier: BSD-3-Clause
#include "core/decimal_text.hpp"

#include <array>
#include <charconv>
#include <cmath>
#include <system_error>

#include <fmt/format.h>

namespace culm::core {

namespace {

/// Digits "d1d2d3…" and the exponent of d1.d2d3….
struct Scientific {
    bool is_negative = false;
    std::string digits;
    int exponent = 0;
};

Scientific shortest_digits(double value) {
    std::array<char, 40> buffer{};
    // Without a precision to_chars writes the fewest digits that read back as the same double, on
    // every machine.
    const auto written = std::to_chars(buffer.data(), buffer.data() + buffer.size(),
                                       std::abs(value), std::chars_format::scientific);
    const std::string text(buffer.data(), written.ptr);
    const std::size_t e = text.find('e');
    Scientific parts;
    parts.is_negative = std::signbit(value);
    parts.digits = text.substr(0, e);
    std::erase(parts.digits, '.');
    parts.exponent = std::stoi(text.substr(e + 1));
    return parts;
}

/// Without an exponent: zeros fill the gap between the point and the digits, on either side.
std::string plain_text(const Scientific& parts) {
    const auto count = static_cast<int>(parts.digits.size());
    if (parts.exponent < 0)
        return fmt::format("0.{:0<{}}{}", "", -parts.exponent - 1, parts.digits);
    if (parts.exponent >= count - 1)
        return fmt::format("{:0<{}}", parts.digits, parts.exponent + 1);
    const auto point = static_cast<std::size_t>(parts.exponent) + 1;
    return fmt::format("{}.{}", parts.digits.substr(0, point), parts.digits.substr(point));
}

std::string exponent_text(const Scientific& parts) {
    return fmt::format("{}{}{}e{}", parts.digits[0], parts.digits.size() > 1 ? "." : "",
                       parts.digits.substr(1), parts.exponent);
}

} // namespace

std::optional<double> parse_decimal(std::string_view text, int power_of_ten) {
    // from_chars accepts no leading plus. "+-1" must stay an error.
    if (text.starts_with('+') && text.size() > 1 && text[1] != '-')
        text.remove_prefix(1);
    double value = 0.0;
    const char* const end = text.data() + text.size();
    const auto read = std::from_chars(text.data(), end, value);
    if (read.ec != std::errc{} || read.ptr != end || !std::isfinite(value))
        return std::nullopt;
    if (power_of_ten == 0 || value == 0.0)
        return value;
    // The exponent is changed in the text, so the result is rounded once. value · 10^n would be
    // rounded twice, because 10⁻³ is not exact as a double.
    const std::size_t e = text.find_first_of("eE");
    const int written =
        e == std::string_view::npos ? 0 : std::stoi(std::string(text.substr(e + 1)));
    const std::string moved = fmt::format("{}e{}", text.substr(0, e), written + power_of_ten);
    const auto shifted = std::from_chars(moved.data(), moved.data() + moved.size(), value);
    if (shifted.ec != std::errc{} || !std::isfinite(value))
        return std::nullopt;
    return value;
}

std::string decimal_text(double value, int power_of_ten) {
    if (!std::isfinite(value) || value == 0.0)
        return std::isfinite(value) && std::signbit(value) ? "-0" : fmt::format("{}", value);
    Scientific parts = shortest_digits(value);
    parts.exponent += power_of_ten;
    // Beyond these exponents an exponent is easier to read than zeros.
    const bool is_plain = parts.exponent >= -7 && parts.exponent <= 15;
    return fmt::format("{}{}", parts.is_negative ? "-" : "",
                       is_plain ? plain_text(parts) : exponent_text(parts));
}

double with_point_moved(double value, int power_of_ten) {
    if (power_of_ten == 0 || value == 0.0 || !std::isfinite(value))
        return value;
    // Parsing fails only if the result is outside the range of double; the product is then zero or
    // infinity.
    return parse_decimal(decimal_text(value), power_of_ten)
        .value_or(value * std::pow(10.0, power_of_ten));
}

} // namespace culm::core
