// SPDX-License-Identifier: BSD-3-Clause
#include "study/config/parameters.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include <fmt/format.h>

namespace culm::study {

namespace {

using core::dimensionless;
using core::gigapascal;
using core::kilogram_per_cubic_metre;
using core::metre_per_second_squared;
using core::millimetre;
using run::CaseSpec;

void set_sphere_diameter(CaseSpec& spec, double diameter) {
    spec.stem.sphere_diameter = diameter;
    spec.stem.bond_length = diameter;
    spec.stem.bond_outer_diameter = diameter;
}

void set_bond_wall(CaseSpec& spec, double wall) {
    const double outer = spec.stem.bond_outer_diameter;
    const double inner = outer - 2.0 * wall;
    // A wall of exactly half the diameter is a solid section; rounding must not make it negative.
    spec.stem.bond_inner_diameter = std::abs(inner) < 1e-12 * outer ? 0.0 : inner;
}

void set_length(CaseSpec& spec, double length) {
    spec.stem.bond_length = length / (spec.stem.sphere_count - 1);
}

/// See ParameterValues::apply_to.
void make_spheres_touch(CaseSpec& spec) {
    const double ratio = spec.stem.bond_outer_diameter / spec.stem.bond_length;
    spec.stem.sphere_diameter = spec.stem.bond_length;
    // Keeps the mass per length: a sphere of diameter d weighs ρπd³/6 and represents the length d.
    spec.stem.density *= ratio * ratio;
}

/// Volume of the bond's section along one bond over that of a sphere.
double section_share(const CaseSpec& spec) {
    const double outer = spec.stem.bond_outer_diameter;
    const double inner = spec.stem.bond_inner_diameter;
    const double diameter = spec.stem.sphere_diameter;
    // π/4 (d_o² − d_i²) l over π/6 d³.
    return 1.5 * (outer * outer - inner * inner) * spec.stem.bond_length /
           (diameter * diameter * diameter);
}

void set_wall_density(CaseSpec& spec, double density) {
    spec.stem.density = density * section_share(spec);
}

// Upper ends are far beyond any plant: they detect a value in the wrong unit.
constexpr Interval diameter_range{0.0, 1000.0, true, false};
constexpr Interval length_range{0.0, 100000.0, true, false};
constexpr Interval density_range{0.0, 30000.0, true, false};
constexpr Interval count_range{2, 10000};
constexpr Interval inner_diameter_range{0.0, 1000.0};
constexpr Interval poisson_range{-1.0, 0.5, true, true};
constexpr Interval modulus_range{0.0, 10000.0, true, false};
constexpr Interval damping_range{0.0, 100000.0};
constexpr Interval gravity_range{-1000.0, 1000.0};

constexpr auto parameter_rows = std::to_array<Parameter>({
    {"spheres", "stem", dimensionless, count_range, true, "56",
     "spheres in the chain, the clamped one included",
     [](const CaseSpec& c) { return double(c.stem.sphere_count); },
     [](CaseSpec& c, double v) { c.stem.sphere_count = static_cast<int>(std::lround(v)); }},
    {"sphere_diameter_mm", "stem", millimetre, diameter_range, false,
     "2.83; with length_mm: the bond length", "diameter of a sphere",
     [](const CaseSpec& c) { return c.stem.sphere_diameter; }, set_sphere_diameter},
    {"bond_length_mm", "stem", millimetre, diameter_range, false, "sphere_diameter_mm",
     "equilibrium distance of neighbouring centres; not together with length_mm",
     [](const CaseSpec& c) { return c.stem.bond_length; },
     [](CaseSpec& c, double v) { c.stem.bond_length = v; }},
    {"length_mm", "stem", millimetre, length_range, false, "(spheres − 1) · bond_length_mm",
     "free length, from the clamped centre to the tip's centre",
     [](const CaseSpec& c) { return c.stem.free_length(); }, set_length},
    {"bond_diameter_mm", "stem", millimetre, diameter_range, false,
     "sphere_diameter_mm if given, else 2.83", "outer diameter of the bonds' section",
     [](const CaseSpec& c) { return c.stem.bond_outer_diameter; },
     [](CaseSpec& c, double v) { c.stem.bond_outer_diameter = v; }},
    {"bond_inner_diameter_mm", "stem", millimetre, inner_diameter_range, false, "0",
     "inner diameter of a hollow section; 0 is solid",
     [](const CaseSpec& c) { return c.stem.bond_inner_diameter; },
     [](CaseSpec& c, double v) { c.stem.bond_inner_diameter = v; }},
    {"bond_wall_mm", "stem", millimetre, diameter_range, false, "half of bond_diameter_mm",
     "wall of a hollow section; not together with bond_inner_diameter_mm",
     [](const CaseSpec& c) {
         return 0.5 * (c.stem.bond_outer_diameter - c.stem.bond_inner_diameter);
     },
     set_bond_wall},
    {"density_kg_m3", "stem", kilogram_per_cubic_metre, density_range, false, "125",
     "density of the spheres", [](const CaseSpec& c) { return c.stem.density; },
     [](CaseSpec& c, double v) { c.stem.density = v; }},
    {"wall_density_kg_m3", "stem", kilogram_per_cubic_metre, density_range, false,
     "2/3 of density_kg_m3 for a solid section of touching spheres",
     "density of the section's material, from which the mass per length follows with the section; "
     "not together with density_kg_m3",
     [](const CaseSpec& c) { return c.stem.density / section_share(c); }, set_wall_density},
    {"poissons_ratio", "stem", dimensionless, poisson_range, false, "0.3",
     "gives the shear modulus Y/(2(1+ν))", [](const CaseSpec& c) { return c.stem.poissons_ratio; },
     [](CaseSpec& c, double v) { c.stem.poissons_ratio = v; }},
    {"bond_youngs_modulus_gpa", "stem", gigapascal, modulus_range, false, "1",
     "Young's modulus Y of the bonds", [](const CaseSpec& c) { return c.stem.bond_youngs_modulus; },
     [](CaseSpec& c, double v) { c.stem.bond_youngs_modulus = v; }},
    {"bond_damping", "stem", dimensionless, damping_range, false, "25",
     "damping parameter β of the bonds", [](const CaseSpec& c) { return c.stem.bond_damping; },
     [](CaseSpec& c, double v) { c.stem.bond_damping = v; }},
    {"axial_gravity_m_s2", "stem", metre_per_second_squared, gravity_range, false, "0",
     "gravity along the stem, positive away from the clamp",
     [](const CaseSpec& c) { return c.stem.axial_acceleration_of_gravity; },
     [](CaseSpec& c, double v) { c.stem.axial_acceleration_of_gravity = v; }},
    {"tip_deflection_mm", "release", millimetre, length_range, false, "15",
     "lateral deflection of the tip before the release; less than the free length",
     [](const CaseSpec& c) { return c.tip_deflection; },
     [](CaseSpec& c, double v) { c.tip_deflection = v; }},
});

std::size_t index_of(const Parameter& parameter) {
    return static_cast<std::size_t>(&parameter - parameter_rows.data());
}

// An error points at the first of these keys that the file gives, so the likeliest comes first.
constexpr std::array<std::string_view, 4> section_keys{"bond_inner_diameter_mm", "bond_wall_mm",
                                                       "bond_diameter_mm", "sphere_diameter_mm"};
constexpr std::array<std::string_view, 5> deflection_keys{
    "tip_deflection_mm", "length_mm", "bond_length_mm", "sphere_diameter_mm", "spheres"};
constexpr std::array<std::string_view, 5> height_keys{"heights_mm", "length_mm", "bond_length_mm",
                                                      "sphere_diameter_mm", "spheres"};

/// Millimetres with as many digits as a message needs.
std::string mm(double metres) {
    return fmt::format("{:.6g}", millimetre.from_si(metres));
}

} // namespace

std::span<const Parameter> parameters() {
    return parameter_rows;
}

const Parameter* find_parameter(std::string_view key) {
    const auto* found = std::ranges::find(parameter_rows, key, &Parameter::key);
    return found == parameter_rows.end() ? nullptr : found;
}

std::string config_text(const Parameter& parameter, double value_in_si) {
    return fmt::format("{}", parameter.unit.from_si(value_in_si));
}

void ParameterValues::set(const Parameter& parameter, double value_in_si) {
    if (parameter.effect)
        of_effects_.emplace_back(*parameter.effect, value_in_si);
    else
        values_[index_of(parameter)] = value_in_si;
}

std::optional<double> ParameterValues::get(const Parameter& parameter) const {
    if (parameter.effect)
        return std::nullopt;
    return values_[index_of(parameter)];
}

bool ParameterValues::has(std::string_view key) const {
    const Parameter* parameter = find_parameter(key);
    return parameter != nullptr && get(*parameter).has_value();
}

void ParameterValues::apply_to(run::CaseSpec& spec) const {
    // Starts from the defaults, not from the current case: a setter such as that of the sphere's
    // diameter changes several members, and no change by an earlier value must remain.
    spec.stem = physics::StemParameters<double>{};
    spec.tip_deflection = run::CaseSpec{}.tip_deflection;
    for (std::size_t i = 0; i < values_.size(); ++i)
        if (values_[i])
            parameter_rows[i].set(spec, *values_[i]);
    if (has("length_mm") && !has("sphere_diameter_mm"))
        make_spheres_touch(spec);
    // The mass of the section needs the section and the spheres.
    if (const auto density = get(*find_parameter("wall_density_kg_m3")))
        set_wall_density(spec, *density);
    for (const auto& [place, value] : of_effects_)
        spec.effects.at(place.effect).values.at(place.value) = value;
}

std::vector<Violation> violations_of(const CaseSpec& spec) {
    std::vector<Violation> found;
    const double inner = spec.stem.bond_inner_diameter;
    const double outer = spec.stem.bond_outer_diameter;
    const double length = spec.stem.free_length();
    if (inner < 0.0)
        found.push_back(
            {section_keys, "stem.bond_wall_mm", mm(0.5 * (outer - inner)),
             fmt::format("must be at most half of the bond diameter, {} mm", mm(outer))});
    else if (inner >= outer)
        found.push_back({section_keys, "stem.bond_inner_diameter_mm", mm(inner),
                         fmt::format("must be smaller than the bond diameter, {} mm", mm(outer))});
    if (!(spec.tip_deflection < length))
        found.push_back(
            {deflection_keys, "release.tip_deflection_mm", mm(spec.tip_deflection),
             fmt::format("must be smaller than the stem's free length, {} mm", mm(length))});
    const auto above = std::ranges::find_if(spec.heights, [&](double height) {
        return height > length * (1.0 + 1e-12); // allows for rounding of the tip's height
    });
    if (above != spec.heights.end())
        found.push_back({height_keys, "study.heights_mm", mm(*above),
                         fmt::format("must not exceed the stem's free length, {} mm", mm(length))});
    return found;
}

} // namespace culm::study
