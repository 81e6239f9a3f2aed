// SPDX-License-Identifier: BSD-3-Clause
// One measured stem: its known properties, the instruments, and the readings of a camera, markers
// or sensors.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace culm::measure {

/// Round section, solid or hollow.
struct CircularSection {
    double diameter = 0.0;      ///< outer, m
    std::optional<double> wall; ///< thickness of the wall, m; empty: solid
};

struct RectangularSection {
    double width = 0.0;  ///< across the plane of motion, m
    double height = 0.0; ///< in the direction of the motion, m
};

/// Any other section, given by its bending properties.
struct GeneralSection {
    double area = 0.0;          ///< m²
    double second_moment = 0.0; ///< for bending in the plane of motion, m⁴
};

using Section = std::variant<CircularSection, RectangularSection, GeneralSection>;

[[nodiscard]] double section_area(const Section& section);          ///< m²
[[nodiscard]] double second_moment_of_area(const Section& section); ///< m⁴
/// Extent in the direction of the motion, m: diameter, height, or √(12 I/A) (a rectangle of the
/// same radius of gyration). The aspect ratio of a stem is its length over this.
[[nodiscard]] double section_depth(const Section& section);

struct AddedMass {
    double height = 0.0;                      ///< of its centre above the clamp, m
    double mass = 0.0;                        ///< kg
    std::optional<double> mass_uncertainty{}; ///< standard uncertainty, kg
    double mass_last_digit = 0.0; ///< one in the last digit that the file writes, kg; 0: not known
};

struct MeasuredStem {
    std::string id;
    double length = 0.0; ///< free length from the clamp to the tip, m
    Section section = CircularSection{};
    double density = 0.0;                 ///< kg/m³; see mass_per_length
    bool is_density_of_spheres = true;    ///< stated as such; false: another key gave the mass
    std::optional<double> poissons_ratio; ///< empty: unknown, the model's default is used
    std::optional<int> spheres;           ///< wanted in the chain; empty: free to choose
    std::vector<AddedMass> added_masses;  ///< by height
};

/// kg/m. A round stem weighs as its chain of touching spheres does, π ρ d²/6 (one sphere of the
/// diameter d per length d, solid whatever the wall: the paper's density is the mass over the
/// volume of a chain, Table 1); other sections weigh ρ A.
[[nodiscard]] double mass_per_length(const MeasuredStem& stem);

/// core::cantilever_frequency() of the stem, Hz.
[[nodiscard]] double beam_frequency(const MeasuredStem& stem, double youngs_modulus);

/// What everybody can check: "80 mm, 1.2 mm, 81 mg (1.02 g/m), EI 2.04e-3 N m² at Y = 20 GPa, beam
/// theory b2 = 123.6 Hz".
[[nodiscard]] std::string stem_line(const MeasuredStem& stem, double youngs_modulus);

/// How the motion began.
enum class ReleaseKind {
    TipPull,      ///< the tip was pulled aside
    HeldStraight, ///< held in line with the clamp: gravity bends it
    Moving        ///< not recorded: the record begins while the stem swings
};

/// Direction of gravity relative to the stem; the model decides whether it acts.
enum class GravityDirection {
    None,
    Axial,     ///< along the stem, toward the clamp (the stem stands upright)
    Transverse ///< in the plane of motion, toward positive deflection
};

/// The point that a column of the table follows.
enum class Reading {
    Row,     ///< a fixed image row: the stem's material slides through it
    Material ///< a mark on the stem: its height is that along the undeformed stem
};

/// Standard uncertainties (one standard deviation: JCGM 100) of the inputs; empty where the file
/// states none.
struct StatedUncertainties {
    std::optional<double> length;            ///< m
    std::optional<double> diameter;          ///< m
    std::optional<double> wall;              ///< m
    std::optional<double> section_width;     ///< m
    std::optional<double> section_height;    ///< m
    std::optional<double> section_area;      ///< m²
    std::optional<double> second_moment;     ///< m⁴
    std::optional<double> density;           ///< kg/m³
    std::optional<double> frames_per_second; ///< relative
    std::optional<double> scale;             ///< relative, of deflections and heights together
    std::optional<double> clamp;             ///< of the height of the clamp in the picture, m
    /// Error of the readings of one row that depends on its position in the picture (a lens, uneven
    /// light): equal in all frames and smooth over the swing, m.
    std::optional<double> row;
};

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
    /// Order of the derivative by time of the deflection that it reads: 0, 1 or 2.
    [[nodiscard]] int time_derivatives() const {
        return quantity == Quantity::Velocity ? 1 : quantity == Quantity::Acceleration ? 2 : 0;
    }
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
/// The units of a quantity as text: "m/s2, mm/s2, g".
[[nodiscard]] std::string unit_names(Quantity quantity);

/// "displacement", "velocity", "acceleration", "strain".
[[nodiscard]] std::string_view to_string(Quantity quantity);

/// Largest number of heights. It exceeds any camera's resolution and limits damaged files.
inline constexpr std::size_t most_heights = 10000;

/// A measurement folder in memory; SI units, heights ascending.
struct Measurement {
    MeasuredStem stem;
    ReleaseKind release = ReleaseKind::TipPull;
    GravityDirection gravity_direction = GravityDirection::None;
    Reading reading = Reading::Row;
    std::optional<double> release_uncertainty; ///< of time 0, s
    double start =
        0.0; ///< of a moving release, on the table's clock, s: earlier frames are left out
    std::optional<double> hold_time;         ///< duration of the hold before the release, s
    std::optional<double> frames_per_second; ///< of the camera
    std::optional<double> noise;             ///< standard deviation of one reading, m
    std::vector<double> noise_by_height;     ///< the same per height, m; empty: not known
    /// Correlation between the errors of a reading in consecutive frames. It is used if a record is
    /// too short to determine it.
    std::optional<double> noise_correlation;
    StatedUncertainties uncertainties;
    std::string specimen; ///< recordings of one specimen share its material; empty: not stated
    std::string rig;      ///< recordings on one rig share its clamp, camera and air; empty: none
    std::optional<double> exposure; ///< of a frame, s
    /// Of a rolling shutter: time between two rows, s; negative if it reads from tip to clamp.
    std::optional<double> row_time;
    std::optional<double> row_height; ///< of an image row on the stem, m
    std::string noise_source; ///< where the noise comes from, for example "40 frames at rest"

    std::vector<double> times;   ///< s, strictly ascending; 0 is the release, or the start of one
                                 ///< that is moving
    std::vector<double> heights; ///< above the clamp, m, ascending; equal only for sensors
    std::vector<Sensor> sensors; ///< (heights); empty: rows of the camera's picture
    /// (times, heights) row-major, in the SI unit of the sensor; NaN where nothing was seen.
    std::vector<double> deflections;
    /// Standard uncertainty of each reading, (times, heights), m; empty: as noise_at().
    std::vector<double> reading_uncertainties;

    /// Remarks of the reader for the user, one sentence each; not written to files.
    std::vector<std::string> remarks;

    [[nodiscard]] double deflection(std::size_t time, std::size_t height) const {
        return deflections[time * heights.size() + height];
    }
    /// The recording itself if no specimen is stated.
    [[nodiscard]] const std::string& specimen_name() const {
        return specimen.empty() ? stem.id : specimen;
    }
    /// Order of the derivative by time of the deflection that is read at a height: 0, 1 or 2.
    [[nodiscard]] int time_derivatives_at(std::size_t row) const {
        return sensors.empty() ? 0 : sensors[row].time_derivatives();
    }
    /// Deflections at one height, (times), m.
    [[nodiscard]] std::vector<double> history(std::size_t height) const;
    /// Root mean square of the readings at one height.
    [[nodiscard]] double rms_reading(std::size_t height) const;
    /// Standard deviation of one reading at a height, m: per height if known, else the common one.
    [[nodiscard]] std::optional<double> noise_at(std::size_t height) const;
};

/// The words of stem.toml: "tip_pull", "held_straight", "moving"; "none", "axial", "transverse";
/// "row", "material".
[[nodiscard]] std::string_view to_string(ReleaseKind kind);
[[nodiscard]] std::string_view to_string(GravityDirection direction);
[[nodiscard]] std::string_view to_string(Reading reading);

/// A sentence, with the remedy, if the middle of the highest camera reading's swing is further from
/// 0 than a quarter of its range; otherwise empty. `is_from_hold`: only if the readings also begin
/// near 0, as those that count from the held position, and not those of a curved stem.
[[nodiscard]] std::string doubt_of_zero(const Measurement& measurement, bool is_from_hold);

} // namespace culm::measure
