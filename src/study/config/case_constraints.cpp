// SPDX-License-Identifier: BSD-3-Clause
#include "study/config/case_constraints.hpp"

#include "study/config/parameters.hpp"

#include <array>

#include <fmt/format.h>

namespace culm::study {

namespace {

using run::CaseSpec;

/// Millimetres with as many digits as a message needs.
std::string mm(double metres) {
    return fmt::format("{:.6g}", millimetre.from_si(metres));
}

std::optional<Violation> section_violation(const CaseSpec& spec) {
    const double inner = spec.stem.bond_inner_diameter;
    const double outer = spec.stem.bond_outer_diameter;
    if (inner < 0.0)
        return Violation{
            "stem.bond_wall_mm", mm(0.5 * (outer - inner)),
            fmt::format("must be at most half of the bond diameter, {} mm", mm(outer))};
    if (inner >= outer)
        return Violation{"stem.bond_inner_diameter_mm", mm(inner),
                         fmt::format("must be smaller than the bond diameter, {} mm", mm(outer))};
    return std::nullopt;
}

std::optional<Violation> deflection_violation(const CaseSpec& spec) {
    const double length = spec.stem.free_length();
    if (spec.tip_deflection < length)
        return std::nullopt;
    return Violation{"release.tip_deflection_mm", mm(spec.tip_deflection),
                     fmt::format("must be smaller than the stem's free length, {} mm", mm(length))};
}

std::optional<Violation> height_violation(const CaseSpec& spec) {
    const double length = spec.stem.free_length();
    for (const double height : spec.heights)
        if (height > length * (1.0 + 1e-12)) // allows for rounding of the tip's height
            return Violation{
                "study.heights_mm", mm(height),
                fmt::format("must not exceed the stem's free length, {} mm", mm(length))};
    return std::nullopt;
}

// An error points at the first of these keys that the file gives, so the likeliest comes first.
constexpr std::array<std::string_view, 4> section_keys{"bond_inner_diameter_mm", "bond_wall_mm",
                                                       "bond_diameter_mm", "sphere_diameter_mm"};
constexpr std::array<std::string_view, 5> deflection_keys{
    "tip_deflection_mm", "length_mm", "bond_length_mm", "sphere_diameter_mm", "spheres"};
constexpr std::array<std::string_view, 5> height_keys{"heights_mm", "length_mm", "bond_length_mm",
                                                      "sphere_diameter_mm", "spheres"};

constexpr std::array constraints{
    CaseConstraint{section_keys, section_violation},
    CaseConstraint{deflection_keys, deflection_violation},
    CaseConstraint{height_keys, height_violation},
};

} // namespace

std::span<const CaseConstraint> case_constraints() {
    return constraints;
}

} // namespace culm::study
