// SPDX-License-Identifier: BSD-3-Clause
#include "measure/folder/sensor.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/core.h>

namespace culm::measure {
namespace {

struct UnitSize {
    Quantity quantity;
    std::string_view name;
    double size;
};

/// The SI unit is the first one of each quantity.
constexpr std::array<UnitSize, 10> units{{{Quantity::Displacement, "m", 1.0},
                                          {Quantity::Displacement, "mm", 1e-3},
                                          {Quantity::Displacement, "um", 1e-6},
                                          {Quantity::Velocity, "m/s", 1.0},
                                          {Quantity::Velocity, "mm/s", 1e-3},
                                          {Quantity::Acceleration, "m/s2", 1.0},
                                          {Quantity::Acceleration, "mm/s2", 1e-3},
                                          {Quantity::Acceleration, "g", 9.80665},
                                          {Quantity::Strain, "m/m", 1.0},
                                          {Quantity::Strain, "um/m", 1e-6}}};

struct Description {
    std::string_view name;
    ReadingUnit printed;
};
/// In the order of Quantity.
constexpr std::array<Description, 4> descriptions{{{"displacement", {1e3, "mm"}},
                                                   {"velocity", {1e3, "mm/s"}},
                                                   {"acceleration", {1.0, "m/s²"}},
                                                   {"strain", {1e6, "µm/m"}}}};

} // namespace

std::string ReadingUnit::text(double value, int decimals) const {
    return std::isfinite(value) ? fmt::format("{:.{}f} {}", factor * value, decimals, name)
                                : fmt::format("- {}", name);
}

ReadingUnit reading_unit(std::span<const Sensor> sensors) {
    if (sensors.empty())
        return {};
    const Quantity first = sensors.front().quantity;
    const bool is_one =
        std::ranges::all_of(sensors, [&](const Sensor& each) { return each.quantity == first; });
    return is_one ? descriptions.at(static_cast<std::size_t>(first)).printed
                  : ReadingUnit{1.0, "SI units"};
}

std::optional<double> unit_size(Quantity quantity, std::string_view unit) {
    const auto found = std::ranges::find_if(units, [&](const UnitSize& each) {
        return each.quantity == quantity && each.name == unit;
    });
    return found == units.end() ? std::nullopt : std::optional(found->size);
}

std::string_view si_unit(Quantity quantity) {
    return std::ranges::find(units, quantity, &UnitSize::quantity)->name;
}

std::string unit_names(Quantity quantity) {
    std::string text;
    for (const UnitSize& each : units)
        if (each.quantity == quantity)
            text += (text.empty() ? "" : ", ") + std::string(each.name);
    return text;
}

std::string_view to_string(Quantity quantity) {
    return descriptions.at(static_cast<std::size_t>(quantity)).name;
}

} // namespace culm::measure
