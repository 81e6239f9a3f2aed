// SPDX-License-Identifier: BSD-3-Clause
#include "study/units.hpp"

#include <array>
#include <charconv>
#include <cmath>
#include <string>
#include <system_error>

namespace culm::study {

namespace {

constexpr std::array known_units{
    Unit{"m", "m", Dimension::Length},
    Unit{"cm", "cm", Dimension::Length, -2},
    millimetre,
    Unit{"µm", "um", Dimension::Length, -6},
    second,
    Unit{"ms", "ms", Dimension::Time, -3},
    Unit{"µs", "us", Dimension::Time, -6},
    Unit{"ns", "ns", Dimension::Time, -9},
    Unit{"Pa", "pa", Dimension::Pressure},
    Unit{"kPa", "kpa", Dimension::Pressure, 3},
    Unit{"MPa", "mpa", Dimension::Pressure, 6},
    gigapascal,
    kilogram_per_cubic_metre,
    Unit{"g/cm³", "g_cm3", Dimension::Density, 3},
    metre_per_second_squared,
};

/// value · 10^power, correctly rounded from the shortest decimal number that identifies `value`.
double with_point_moved(double value, int power) {
    if (power == 0 || value == 0.0 || !std::isfinite(value))
        return value;
    std::array<char, 40> digits{};
    const auto written = std::to_chars(digits.data(), digits.data() + digits.size(), value,
                                       std::chars_format::scientific);
    std::string text(digits.data(), written.ptr);
    const std::size_t e = text.find('e');
    const int exponent = std::stoi(text.substr(e + 1)) + power;
    text = text.substr(0, e) + "e" + std::to_string(exponent);
    double moved = 0.0;
    const auto read = std::from_chars(text.data(), text.data() + text.size(), moved);
    // Beyond the range of double only the product says what is left: zero or infinity.
    return read.ec == std::errc{} ? moved : value * std::pow(10.0, power);
}

} // namespace

double Unit::to_si(double value) const {
    return with_point_moved(value, power_of_ten);
}

double Unit::from_si(double value) const {
    return with_point_moved(value, -power_of_ten);
}

KeyParts split_key(std::string_view key) {
    KeyParts parts{key, std::nullopt};
    for (const Unit& unit : known_units) {
        const bool longer = !parts.unit || unit.suffix.size() > parts.unit->suffix.size();
        if (longer && key.size() > unit.suffix.size() + 1 && key.ends_with(unit.suffix) &&
            key[key.size() - unit.suffix.size() - 1] == '_')
            parts = {key.substr(0, key.size() - unit.suffix.size() - 1), unit};
    }
    return parts;
}

} // namespace culm::study
