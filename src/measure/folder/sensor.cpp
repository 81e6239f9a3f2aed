// SPDX-License-Identifier: BSD-3-Clause
#include "measure/folder/sensor.hpp"

#include <algorithm>
#include <array>

#include <fmt/core.h>

namespace culm::measure {
namespace {

struct UnitSize {
    Quantity quantity;
    std::string_view name;
    double size;
};

constexpr std::array<UnitSize, 10> units{{{Quantity::Displacement, "mm", 1e-3},
                                          {Quantity::Displacement, "m", 1.0},
                                          {Quantity::Displacement, "um", 1e-6},
                                          {Quantity::Velocity, "m/s", 1.0},
                                          {Quantity::Velocity, "mm/s", 1e-3},
                                          {Quantity::Acceleration, "m/s2", 1.0},
                                          {Quantity::Acceleration, "mm/s2", 1e-3},
                                          {Quantity::Acceleration, "g", 9.80665},
                                          {Quantity::Strain, "m/m", 1.0},
                                          {Quantity::Strain, "um/m", 1e-6}}};

} // namespace

std::string ReadingUnit::text(double value, int decimals) const {
    return fmt::format("{:.{}f} {}", factor * value, decimals, name);
}

ReadingUnit reading_unit(std::span<const Sensor> sensors) {
    if (sensors.empty())
        return {};
    const Quantity first = sensors.front().quantity;
    if (std::ranges::any_of(sensors, [&](const Sensor& each) { return each.quantity != first; }))
        return {1.0, "SI units"};
    switch (first) {
    case Quantity::Velocity:
        return {1e3, "mm/s"};
    case Quantity::Acceleration:
        return {1.0, "m/s²"};
    case Quantity::Strain:
        return {1e6, "µm/m"};
    case Quantity::Displacement:
        break;
    }
    return {};
}

std::optional<double> unit_size(Quantity quantity, std::string_view unit) {
    const auto found = std::ranges::find_if(units, [&](const UnitSize& each) {
        return each.quantity == quantity && each.name == unit;
    });
    return found == units.end() ? std::nullopt : std::optional(found->size);
}

std::string_view si_unit(Quantity quantity) {
    return std::ranges::find_if(
               units,
               [&](const UnitSize& each) { return each.quantity == quantity && each.size == 1.0; })
        ->name;
}

std::string_view unit_names(Quantity quantity) {
    switch (quantity) {
    case Quantity::Velocity:
        return "m/s, mm/s";
    case Quantity::Acceleration:
        return "m/s2, mm/s2, g";
    case Quantity::Strain:
        return "m/m, um/m";
    case Quantity::Displacement:
        break;
    }
    return "mm, m, um";
}

std::string_view to_string(Quantity quantity) {
    switch (quantity) {
    case Quantity::Velocity:
        return "velocity";
    case Quantity::Acceleration:
        return "acceleration";
    case Quantity::Strain:
        return "strain";
    case Quantity::Displacement:
        break;
    }
    return "displacement";
}

} // namespace culm::measure
