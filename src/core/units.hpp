// SPDX-License-Identifier: BSD-3-Clause
// Units in which users write numbers, and how keys name them: "bond_length_mm" is the quantity
// "bond_length" in millimetres.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace culm::core {

enum class Dimension {
    None,
    Length,
    Area,
    SecondMoment,
    Time,
    Mass,
    Pressure,
    Density,
    LinearDensity,
    Acceleration
};

/// A unit that is a power of ten of the SI unit.
struct Unit {
    std::string_view name;   ///< as it is printed, for example "kg/m³"
    std::string_view suffix; ///< as a key ends with it, for example "kg_m3"
    Dimension dimension = Dimension::None;
    int power_of_ten = 0; ///< 1 unit = 10^power_of_ten SI units

    /// The decimal point of the number as it was written is moved, so that 2.83 mm is exactly the
    /// double 2.83e-3 and turns back into 2.83; a multiplication would be off by a rounding.
    [[nodiscard]] double to_si(double value) const;
    [[nodiscard]] double from_si(double value) const;
};

inline constexpr Unit dimensionless{"", "", Dimension::None};
inline constexpr Unit millimetre{"mm", "mm", Dimension::Length, -3};
inline constexpr Unit gram{"g", "g", Dimension::Mass, -3};
inline constexpr Unit second{"s", "s", Dimension::Time};
inline constexpr Unit gigapascal{"GPa", "gpa", Dimension::Pressure, 9};
inline constexpr Unit kilogram_per_cubic_metre{"kg/m³", "kg_m3", Dimension::Density};
inline constexpr Unit metre_per_second_squared{"m/s²", "m_s2", Dimension::Acceleration};

/// A key taken apart.
struct KeyParts {
    std::string_view quantity;
    std::optional<Unit> unit; ///< nothing when the key ends with no unit that is known here
};

/// Splits at the longest unit that the key ends with; units which no valid key uses (Pa, cm, ms …)
/// are known too, so that a mistaken unit can be explained.
[[nodiscard]] KeyParts split_key(std::string_view key);

/// The other spelling of a key: "length_m" of "length_mm". Empty if it has none, as the keys of
/// times and of SI units.
[[nodiscard]] std::string si_key(std::string_view key);

} // namespace culm::core
