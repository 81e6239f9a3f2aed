// SPDX-License-Identifier: BSD-3-Clause
// What a column of a recording measures, and with which instrument.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace culm::measure {

enum class Quantity {
    Displacement, ///< of the axis or of a mark, m
    Velocity,     ///< of the material, at a right angle to the undeformed stem, m/s
    Acceleration, ///< along the normal of the section, which turns with it, m/s²
    Strain        ///< of a fibre along the stem, dimensionless
};

/// The instrument of one column; SI units. The default is a row of the camera's picture.
struct Sensor {
    std::string column;  ///< its name in deflection.csv; empty: a row of the picture, "h=14mm"
    double height = 0.0; ///< along the undeformed stem, above the clamp, m
    Quantity quantity = Quantity::Displacement;
    std::string unit;                ///< of the column, as in the file
    double distance_from_axis = 0.0; ///< of the mark or fibre, toward positive deflection, m
    double high_pass = 0.0;          ///< cut-off of a first-order filter, Hz; 0: none
    double low_pass = 0.0;           ///< likewise
    std::optional<double> noise;     ///< standard deviation of one reading
    /// Standard uncertainties; empty: the defaults of docs/measurements.md.
    std::optional<double> scale_uncertainty;  ///< relative
    std::optional<double> offset_uncertainty; ///< of a constant error
    std::optional<double> drift_uncertainty;  ///< of an error that grows linearly, per s

    [[nodiscard]] bool is_camera() const { return column.empty(); }
    [[nodiscard]] bool needs_rates() const {
        return quantity == Quantity::Velocity || quantity == Quantity::Acceleration;
    }
};

/// Is a row one of the camera's picture? `sensors` (rows); empty: all rows are.
[[nodiscard]] inline bool is_of_camera(std::span<const Sensor> sensors, std::size_t row) {
    return sensors.empty() || sensors[row].is_camera();
}

/// A unit of readings: SI unit times `factor` gives the number to print.
struct ReadingUnit {
    double factor = 1e3;
    std::string_view name = "mm";

    [[nodiscard]] std::string text(double value, int decimals = 4) const; ///< with the unit
};

/// The unit in which readings of these sensors are printed: mm for a camera (`sensors` is empty)
/// and for displacements, mm/s, m/s², or µm/m. Readings of several quantities have no common unit;
/// their root mean square is in SI units.
[[nodiscard]] ReadingUnit reading_unit(std::span<const Sensor> sensors);

/// SI units per unit of a column; empty if the unit does not belong to the quantity.
[[nodiscard]] std::optional<double> unit_size(Quantity quantity, std::string_view unit);
/// The SI unit of a quantity: "m", "m/s", "m/s2", "m/m".
[[nodiscard]] std::string_view si_unit(Quantity quantity);
/// The units of a quantity as text: "m/s2, mm/s2, g".
[[nodiscard]] std::string unit_names(Quantity quantity);

/// "displacement", "velocity", "acceleration", "strain".
[[nodiscard]] std::string_view to_string(Quantity quantity);

} // namespace culm::measure
