// SPDX-License-Identifier: BSD-3-Clause
#include "measure/folder/stem_section.hpp"

#include "core/decimal_text.hpp"
#include "core/units.hpp"
#include "measure/folder/measurement_files.hpp"

#include <array>
#include <cmath>
#include <vector>

#include <fmt/format.h>

namespace culm::measure {

namespace {

constexpr core::Interval section_width = StemLimits::width;
constexpr core::Interval above_zero{0.0, 1e12, true};

/// "length_limits_mm" of "length_mm".
std::string key_with(const std::string& key, std::string_view word) {
    const core::KeyParts parts = core::split_key(key);
    return fmt::format("{}_{}_{}", parts.quantity, word, parts.unit->suffix);
}

} // namespace

std::string uncertainty_key(const std::string& key) {
    return key_with(key, "uncertainty");
}

std::optional<double> read_uncertainty(const core::TomlTable& table, const std::string& quantity,
                                       double value, double largest) {
    const core::Interval range{0.0, largest, true};
    const auto standard = table.quantity(uncertainty_key(quantity), range);
    const auto expanded = table.quantity(key_with(quantity, "expanded_uncertainty"), range);
    const auto factor = table.number("coverage_factor", {1.0, 10.0});
    const std::string key = table.spelling_of(uncertainty_key(quantity));
    const std::string expanded_key = table.spelling_of(key_with(quantity, "expanded_uncertainty"));
    const std::string limits_key = table.spelling_of(key_with(quantity, "limits"));
    const core::Unit unit = core::split_key(limits_key).unit.value_or(core::dimensionless);
    const std::vector<double> limits = table.numbers(limits_key, {0.0, unit.from_si(largest)});
    if (int(table.has(key)) + int(table.has(expanded_key)) + int(table.has(limits_key)) > 1) {
        table.fault(table.has(limits_key) ? limits_key : expanded_key,
                    fmt::format("is given in addition to {}: one of them is enough",
                                table.has(key) ? key : expanded_key));
        return std::nullopt;
    }
    if (standard)
        return standard;
    if (expanded) {
        table.missing("coverage_factor",
                      fmt::format("ratio of {} to the standard uncertainty", expanded_key));
        return *expanded / factor.value_or(1.0);
    }
    if (limits.empty())
        return std::nullopt;
    const double low = unit.to_si(limits.front());
    const double high = unit.to_si(limits.back());
    if (limits.size() != 2 || !(low < high) || value < low || value > high) {
        table.fault(limits_key, fmt::format("must be [lowest, highest] with {} between them",
                                            core::decimal_text(value, -unit.power_of_ten)));
        return std::nullopt;
    }
    // Any value between the limits is equally likely (JCGM 101, 6.4.2): variance a²/3.
    return 0.5 * (high - low) / std::sqrt(3.0);
}

void read_section(const core::TomlTable& table, Measurement& measurement) {
    MeasuredStem& stem = measurement.stem;
    StatedUncertainties& stated = measurement.uncertainties;
    struct Part {
        std::string key;
        core::Interval range;
        std::string meaning;
        std::size_t shape;
        std::optional<double>& uncertainty;
    };
    const std::array<std::string, 2> shapes{"rectangle", "general"};
    const std::array<Part, 4> parts{
        {{"width_mm", section_width, "across the plane of motion", 0, stated.section_width},
         {"height_mm", section_width, "in the direction of the motion", 0, stated.section_height},
         {"area_mm2", above_zero, "of the section", 1, stated.section_area},
         {"second_moment_mm4", above_zero, "for bending in the plane of motion", 1,
          stated.second_moment}}};
    const auto shape = table.word("shape", shapes);
    table.missing("shape", "must be \"rectangle\" or \"general\"");
    std::array<double, 4> values{};
    for (std::size_t i = 0; i < parts.size(); ++i) {
        const Part& part = parts[i];
        values[i] = table.quantity(part.key, part.range).value_or(0.0);
        part.uncertainty = read_uncertainty(table, part.key, values[i], part.range.high);
        const std::string key = table.spelling_of(part.key);
        if (shape && shape != part.shape && part.uncertainty)
            table.fault(table.spelling_of(uncertainty_key(part.key)),
                        fmt::format("belongs to shape = \"{}\"", shapes[part.shape]));
        if (shape == part.shape)
            table.missing(key, part.meaning);
        else if (shape && table.has(key))
            table.fault(key, fmt::format("belongs to shape = \"{}\"", shapes[part.shape]));
    }
    if (shape == std::size_t{0})
        stem.section = RectangularSection{values[0], values[1]};
    else if (shape)
        stem.section = GeneralSection{values[2], values[3]};
}

void read_round_section(const core::TomlTable& table, bool has_other_section, MeasuredStem& stem) {
    const auto wall = table.quantity("wall_mm", {0.0, section_width.high, true});
    const std::string wall_key = table.spelling_of("wall_mm");
    if (has_other_section) {
        static_cast<void>(table.quantity("diameter_mm", section_width));
        // The diameter of a round stem or a section, not both.
        for (const std::string& key : {table.spelling_of("diameter_mm"), wall_key})
            if (table.has(key))
                table.fault(key, "the file also has a [section]: remove one of them");
        return;
    }
    const double diameter = table.required_quantity(
        "diameter_mm", section_width, "outer diameter (or a [section] for other shapes)");
    if (diameter > 0.0 && wall && *wall >= 0.5 * diameter)
        table.fault(wall_key, fmt::format("must be below half the diameter, {} mm",
                                          core::decimal_text(0.5 * diameter, 3)));
    stem.section = CircularSection{diameter, wall};
}

void read_density(const core::TomlTable& table, Measurement& measurement) {
    struct Form {
        std::string key;
        double density_per_unit = 1.0;
    };
    MeasuredStem& stem = measurement.stem;
    stem.density = 1.0;
    const double unit_mass = mass_per_length(stem);
    stem.density = 0.0;
    const double area = section_area(stem.section);
    const bool is_known = unit_mass > 0.0 && stem.length > 0.0;
    const std::array<Form, 4> forms{
        {{"density_kg_m3", 1.0},
         {"linear_density_kg_m", is_known ? 1.0 / unit_mass : 1.0},
         {"material_density_kg_m3", is_known ? area / unit_mass : 1.0},
         {"mass_mg", is_known ? 1.0 / (unit_mass * stem.length) : 1.0}}};
    std::string first;
    for (const Form& form : forms) {
        const std::string key = table.spelling_of(form.key);
        const core::Interval range{0.0, StemLimits::density.high / form.density_per_unit, true};
        const auto value =
            table.quantity(form.key, form.density_per_unit == 1.0 ? StemLimits::density : range);
        const auto uncertainty = read_uncertainty(table, form.key, value.value_or(0.0), range.high);
        if (!table.has(key))
            continue;
        if (!first.empty())
            table.fault(key,
                        fmt::format("is given in addition to {}: one of them is enough", first));
        first = key;
        stem.density = value.value_or(0.0) * form.density_per_unit;
        stem.is_density_of_spheres = form.key == "density_kg_m3";
        if (uncertainty)
            measurement.uncertainties.density = *uncertainty * form.density_per_unit;
    }
    if (first.empty())
        table.missing("density_kg_m3",
                      "in kg/m³ (of a round stem that of touching spheres; or linear_density_kg_m, "
                      "material_density_kg_m3 or mass_mg of the free length)");
}

} // namespace culm::measure
