// SPDX-License-Identifier: BSD-3-Clause
// The parts of stem.toml that give a stem its stiffness and mass: section and density.
#pragma once

#include "core/toml/table.hpp"
#include "measure/folder/measurement.hpp"

#include <optional>
#include <string>

namespace culm::measure {

/// A quantity's standard uncertainty in SI units, in one of three forms (JCGM 100 and 101): u
/// itself, an expanded uncertainty U = k u, or limits ±a without further knowledge, u = a/√3.
[[nodiscard]] std::optional<double> read_uncertainty(const core::TomlTable& table,
                                                     const std::string& key, double value,
                                                     double largest);

/// The key of u itself: "length_uncertainty_mm" of "length_mm".
[[nodiscard]] std::string uncertainty_key(const std::string& key);

/// The table [section] of a stem that is not round.
void read_section(const core::TomlTable& table, Measurement& measurement);

/// Diameter and wall in [stem]; refused if there is another section.
void read_round_section(const core::TomlTable& table, bool has_other_section, MeasuredStem& stem);

/// The density in the convention of mass_per_length(), from exactly one of four keys of [stem]:
/// that density, the mass per length, the density of the section's material, or the mass of the
/// free length. The section must be known.
void read_density(const core::TomlTable& table, Measurement& measurement);

} // namespace culm::measure
