// SPDX-License-Identifier: BSD-3-Clause
#include "measure/folder/measurement.hpp"

#include "core/cantilever.hpp"
#include "core/order_statistics.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <fmt/core.h>

namespace culm::measure {

namespace {

double inner_diameter(const CircularSection& circle) {
    return circle.wall ? circle.diameter - 2.0 * *circle.wall : 0.0;
}

struct UnitSize {
    Quantity quantity;
    std::string_view name;
    double size;
};

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

// Area and second moment for bending: ring π/4 (D² − d²) and π/64 (D⁴ − d⁴), rectangle b h and
// b h³/12.
double section_area(const Section& section) {
    if (const auto* circle = std::get_if<CircularSection>(&section)) {
        const double inner = inner_diameter(*circle);
        return std::numbers::pi / 4.0 * (circle->diameter * circle->diameter - inner * inner);
    }
    if (const auto* rectangle = std::get_if<RectangularSection>(&section))
        return rectangle->width * rectangle->height;
    return std::get<GeneralSection>(section).area;
}

double second_moment_of_area(const Section& section) {
    if (const auto* circle = std::get_if<CircularSection>(&section))
        return std::numbers::pi / 64.0 *
               (std::pow(circle->diameter, 4) - std::pow(inner_diameter(*circle), 4));
    if (const auto* rectangle = std::get_if<RectangularSection>(&section))
        return rectangle->width * std::pow(rectangle->height, 3) / 12.0;
    return std::get<GeneralSection>(section).second_moment;
}

double section_depth(const Section& section) {
    if (const auto* circle = std::get_if<CircularSection>(&section))
        return circle->diameter;
    if (const auto* rectangle = std::get_if<RectangularSection>(&section))
        return rectangle->height;
    // The height of the rectangle with this radius of gyration: I/A = h²/12.
    const auto& general = std::get<GeneralSection>(section);
    return std::sqrt(12.0 * general.second_moment / general.area);
}

double mass_per_length(const MeasuredStem& stem) {
    if (const auto* circle = std::get_if<CircularSection>(&stem.section))
        // One sphere, π d³/6, per length d.
        return stem.density * std::numbers::pi / 6.0 * circle->diameter * circle->diameter;
    return stem.density * section_area(stem.section);
}

double beam_frequency(const MeasuredStem& stem, double youngs_modulus) {
    return core::cantilever_frequency(
        stem.length, youngs_modulus * second_moment_of_area(stem.section), mass_per_length(stem));
}

std::string stem_line(const MeasuredStem& stem, double youngs_modulus) {
    std::string section;
    std::string otherwise;
    if (const auto* circle = std::get_if<CircularSection>(&stem.section)) {
        section = fmt::format("{:.4g} mm", 1e3 * circle->diameter);
        if (circle->wall)
            section += fmt::format(" (wall {:.4g} mm)", 1e3 * *circle->wall);
        if (stem.is_density_of_spheres)
            otherwise = fmt::format(" as touching spheres of this density; {:.3g} g/m as a rod",
                                    1e3 * stem.density * section_area(stem.section));
    } else if (const auto* rectangle = std::get_if<RectangularSection>(&stem.section)) {
        section =
            fmt::format("{:.4g} x {:.4g} mm", 1e3 * rectangle->width, 1e3 * rectangle->height);
    } else {
        section = fmt::format("{:.4g} mm²", 1e6 * section_area(stem.section));
    }
    const double mass = stem.length * mass_per_length(stem);
    return fmt::format(
        "{:.4g} mm, {}, {} ({:.3g} g/m{}), EI {:.3g} N m² at Y = {:.4g} GPa, beam theory b2 = "
        "{:.4g} Hz{}",
        1e3 * stem.length, section,
        mass < 1e-3 ? fmt::format("{:.3g} mg", 1e6 * mass) : fmt::format("{:.4g} g", 1e3 * mass),
        1e3 * mass_per_length(stem), otherwise,
        youngs_modulus * second_moment_of_area(stem.section), 1e-9 * youngs_modulus,
        beam_frequency(stem, youngs_modulus),
        std::clamp(youngs_modulus, 1e4, 1e12) == youngs_modulus
            ? ""
            : "; no material has this Y: check the units of lengths, mass and time");
}

std::string doubt_of_zero(const Measurement& measurement, bool is_from_hold) {
    const std::size_t row = measurement.heights.size() - 1;
    if (measurement.release == ReleaseKind::HeldStraight ||
        (is_from_hold && measurement.release == ReleaseKind::Moving) ||
        measurement.gravity_direction == GravityDirection::Transverse ||
        !is_of_camera(measurement.sensors, row))
        return {};
    std::vector<double> all = measurement.history(row);
    std::erase_if(all, [](double value) { return std::isnan(value); });
    const std::vector<double> late(all.begin() + std::ptrdiff_t(all.size() / 2), all.end());
    if (late.size() < 12)
        return {};
    const double middle = 0.5 * (core::quantile(late, 0.02) + core::quantile(late, 0.98));
    const double range = std::ranges::max(all) - std::ranges::min(all);
    if (std::abs(middle) <= 0.25 * range || (is_from_hold && std::abs(all.front()) > 0.1 * range))
        return {};
    return fmt::format(
        "the stem swings about {:.3g} mm at h = {:g} mm, not about 0. Deflections count from the "
        "undeformed stem, so only one that is curved at rest will fit: subtract the rest position "
        "from each column (culm import does it with [motion] zero = \"at_rest\")",
        1e3 * middle, 1e3 * measurement.heights[row]);
}

std::vector<double> Measurement::history(std::size_t height) const {
    std::vector<double> values;
    values.reserve(times.size());
    for (std::size_t i = 0; i < times.size(); ++i)
        values.push_back(deflection(i, height));
    return values;
}

double Measurement::rms_reading(std::size_t height) const {
    double squares = 0.0;
    double count = 0.0;
    for (std::size_t i = 0; i < times.size(); ++i)
        if (const double value = deflection(i, height); !std::isnan(value)) {
            squares += value * value;
            count += 1.0;
        }
    return std::sqrt(squares / std::max(count, 1.0));
}

std::optional<double> Measurement::noise_at(std::size_t height) const {
    if (height < noise_by_height.size())
        return noise_by_height[height];
    return noise;
}

std::string_view to_string(ReleaseKind kind) {
    constexpr std::array<std::string_view, 3> words{"tip_pull", "held_straight", "moving"};
    return words.at(static_cast<std::size_t>(kind));
}

std::string_view to_string(GravityDirection direction) {
    constexpr std::array<std::string_view, 3> words{"none", "axial", "transverse"};
    return words.at(static_cast<std::size_t>(direction));
}

std::string_view to_string(Reading reading) {
    return reading == Reading::Row ? "row" : "material";
}

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
