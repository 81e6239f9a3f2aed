// SPDX-License-Identifier: BSD-3-Clause
// The parameters that a study can set or vary, their units and allowed ranges.
#pragma once

#include "core/interval.hpp"
#include "core/units.hpp"
#include "run/case_spec.hpp"

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace culm::study {

using core::Interval;

using core::Unit;

/// Identifies a parameter of one of a case's effects.
struct EffectPlace {
    std::size_t effect = 0;
    std::size_t value = 0;
};

/// One row of the table. Values in `range` and `default_text` are in the unit that the key names;
/// `get` and `set` use SI.
struct Parameter {
    std::string_view key;     ///< as in the TOML file, for example "bond_youngs_modulus_gpa"
    std::string_view section; ///< the TOML table it belongs to: "stem" or "release"
    Unit unit;
    Interval range;
    bool is_whole_number = false;
    std::string_view default_text;
    std::string_view meaning;
    double (*get)(const run::CaseSpec&) = nullptr;
    void (*set)(run::CaseSpec&, double) = nullptr;
    std::optional<EffectPlace> effect = {}; ///< of an effect's parameter, in place of get and set
};

/// A row outside the table, with the texts that it refers to.
struct EffectParameterRow {
    std::string key;
    std::string unit;
    std::string meaning;
    Parameter parameter;
};

/// The table. Its order is the order in which `ParameterValues::apply_to` calls the setters.
[[nodiscard]] std::span<const Parameter> parameters();

/// The row of that key, or nullptr.
[[nodiscard]] const Parameter* find_parameter(std::string_view key);

/// The SI value in the parameter's unit, in the fewest digits that identify it.
[[nodiscard]] std::string config_text(const Parameter& parameter, double value_in_si);

/// Two keys that define the same quantity, so that only one of them may be given.
struct ExclusiveKeys {
    std::string_view first;
    std::string_view second;
};

inline constexpr std::array exclusive_keys{
    ExclusiveKeys{"length_mm", "bond_length_mm"},
    ExclusiveKeys{"bond_wall_mm", "bond_inner_diameter_mm"},
    ExclusiveKeys{"wall_density_kg_m3", "density_kg_m3"},
};

/// Which parameters are given, and their values in SI.
class ParameterValues {
  public:
    void set(const Parameter& parameter, double value_in_si);
    [[nodiscard]] std::optional<double> get(const Parameter& parameter) const;
    [[nodiscard]] bool has(std::string_view key) const;

    /// Makes the case's stem, release and effects' values from the defaults (Table 1 of Schramm et
    /// al. 2019) and the given values. Rules for what is not given:
    ///   - bond_length and bond_diameter follow sphere_diameter;
    ///   - length gives bond_length = length/(spheres − 1);
    ///   - bond_wall gives the inner diameter, bond_diameter − 2 bond_wall;
    ///   - length without sphere_diameter makes the spheres touch: sphere diameter = bond length,
    ///     with the density scaled by (bond_diameter/bond_length)² so that the mass per length
    ///     stays that of touching spheres of the bond's diameter, ρ π d²/6, for any number of
    ///     spheres. Were the diameter not the bond length, the shear lever arms of the law
    ///     `schramm2019` (the radii) would not span the bond, and the frequency of a stem would
    ///     depend on the number of spheres (docs/config.md has the figures).
    ///   - wall_density gives the spheres the mass of their part of the section, wall_density ·
    ///     π (d_o² − d_i²)/4 · bond_length, whatever their diameter.
    void apply_to(run::CaseSpec& spec) const;

  private:
    std::vector<std::optional<double>> values_ =
        std::vector<std::optional<double>>(parameters().size()); ///< by row of the table
    std::vector<std::pair<EffectPlace, double>> of_effects_;
};

/// A broken constraint between the parameters of one case, in the words of the config file.
struct Violation {
    std::span<const std::string_view> keys; ///< that influence it, the likeliest first
    std::string key;     ///< to blame, with its section, for example "release.tip_deflection_mm"
    std::string value;   ///< in the key's unit
    std::string allowed; ///< what it must be
};

/// The constraints that a case breaks, in addition to the range of each parameter.
[[nodiscard]] std::vector<Violation> violations_of(const run::CaseSpec& spec);

} // namespace culm::study
