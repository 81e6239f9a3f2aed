// SPDX-License-Identifier: BSD-3-Clause
#include "core/units.hpp"

#include "core/decimal_text.hpp"

#include <algorithm>
#include <array>

#include <fmt/format.h>

namespace culm::core {

namespace {

constexpr std::array known_units{
    Unit{"m", "m", Dimension::Length},
    Unit{"cm", "cm", Dimension::Length, -2},
    millimetre,
    Unit{"µm", "um", Dimension::Length, -6},
    Unit{"m²", "m2", Dimension::Area},
    Unit{"mm²", "mm2", Dimension::Area, -6},
    Unit{"m⁴", "m4", Dimension::SecondMoment},
    Unit{"mm⁴", "mm4", Dimension::SecondMoment, -12},
    second,
    Unit{"ms", "ms", Dimension::Time, -3},
    Unit{"µs", "us", Dimension::Time, -6},
    Unit{"ns", "ns", Dimension::Time, -9},
    Unit{"kg", "kg", Dimension::Mass},
    gram,
    Unit{"mg", "mg", Dimension::Mass, -6},
    Unit{"Pa", "pa", Dimension::Pressure},
    Unit{"kPa", "kpa", Dimension::Pressure, 3},
    Unit{"MPa", "mpa", Dimension::Pressure, 6},
    gigapascal,
    kilogram_per_cubic_metre,
    Unit{"g/cm³", "g_cm3", Dimension::Density, 3},
    Unit{"kg/m", "kg_m", Dimension::LinearDensity},
    metre_per_second_squared,
};

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
        // The longest ending wins: "_kg_m3" also ends with "_m3".
        const bool longer = !parts.unit || unit.suffix.size() > parts.unit->suffix.size();
        if (longer && key.size() > unit.suffix.size() + 1 && key.ends_with(unit.suffix) &&
            key[key.size() - unit.suffix.size() - 1] == '_')
            parts = {key.substr(0, key.size() - unit.suffix.size() - 1), unit};
    }
    return parts;
}

std::string si_key(std::string_view key) {
    const KeyParts parts = split_key(key);
    if (!parts.unit || parts.unit->power_of_ten == 0 || parts.unit->dimension == Dimension::Time)
        return {};
    const auto si = std::ranges::find_if(known_units, [&](const Unit& unit) {
        return unit.dimension == parts.unit->dimension && unit.power_of_ten == 0;
    });
    return fmt::format("{}_{}", parts.quantity, si->suffix);
}

} // namespace culm::core
