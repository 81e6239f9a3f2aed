// SPDX-License-Identifier: BSD-3-Clause
// Predicted readings of a simulated chain: the curve through its spheres, at the heights and times
// of the measurement.
#pragma once

#include "measure/folder/measurement.hpp"

#include <array>
#include <cstddef>
#include <span>

namespace culm::measure {

// The curve between the centres of the spheres is a cubic through four of them. Its error is at
// most 3/128 l⁴ |y| between the two inner ones and 1/24 l⁴ |y| in the first and last bond, l the
// bond length: for mode 1 of a cantilever of 56 spheres 6e-8 of the tip deflection, for mode 2
// 2e-6. `positions` are the spheres' centres, (spheres, dimensions) row-major in metres, axis 0
// along the undeformed stem and axis 1 lateral, from the clamp to the tip with axis 0 increasing.

/// The deflection, m, in the image row at `height` above the clamp; NaN below the clamp and above
/// the tip. The material slides through the row, so it depends on the axial positions too.
[[nodiscard]] double deflection_in_row(std::span<const double> positions, int dimensions,
                                       double height);

/// The deflection, m, of a mark on the material at `height` along the undeformed stem, whose
/// neighbouring centres are `bond_length` apart (m). It does not depend on the axial positions. NaN
/// outside the chain. The chain includes half a bond beyond the tip's centre, so that rounding does
/// not exclude a mark at the tip.
[[nodiscard]] double deflection_of_mark(std::span<const double> positions, int dimensions,
                                        double bond_length, double height);

/// The chain at one time, each (spheres, dimensions) row-major like `positions`, in a frame that
/// may move with the support. Velocities and accelerations are empty if no sensor needs them.
struct ChainSample {
    std::span<const double> positions;     ///< m
    std::span<const double> velocities;    ///< m/s
    std::span<const double> accelerations; ///< m/s²
};

/// What acts on a sensor in addition to the chain's motion.
struct SensorSurroundings {
    double support_velocity = 0.0;           ///< lateral, m/s
    double support_acceleration = 0.0;       ///< lateral, m/s²
    std::array<double, 2> gravity{0.0, 0.0}; ///< axial and lateral, m/s²
};

/// The reading of a sensor on the material at `height` along the undeformed stem, in the SI unit of
/// its quantity. Directions are those of the chain's curve, so the shear of the section is
/// neglected. With its angle θ, curvature κ and the distance e of the sensor from the axis:
/// displacement of a mark y + e (cos θ − 1); velocity v_y; acceleration (a − g)·n + g_y with the
/// normal n = (−sin θ, cos θ), as a seismic mass measures it, without its value in the undeformed
/// stem and without terms of e (of second order); strain −e κ. NaN outside the chain.
[[nodiscard]] double reading_of_sensor(const Sensor& sensor, const ChainSample& chain,
                                       int dimensions, double bond_length, double height,
                                       const SensorSurroundings& surroundings);

/// Passes the samples, at distances of `interval` s, through the sensor's first-order filters. Each
/// is solved exactly for readings that are linear between two samples. Before the first sample the
/// reading was constant.
void filter(const Sensor& sensor, double interval, std::span<double> samples);

/// Interpolation of a value at one time from samples: a cubic through four of them in time. Its
/// error is at most 3/128 Δt⁴ |y''''| (1/24 in the first and last interval), Δt the sample
/// interval: 5e-8 of the amplitude for 60 Hz and Δt = 0.1 ms.
struct TimeStencil {
    std::size_t first = 0;
    std::size_t samples = 0; ///< 0: the time lies after the last sample
    std::array<double, 4> weights{};
    std::array<double, 4> rates{}; ///< weights of the derivative by time, 1/s

    /// Value and derivative by time (per s) of column j of samples (times, columns) row-major; NaN
    /// if there are no samples.
    [[nodiscard]] double value(std::span<const double> table, std::size_t columns,
                               std::size_t j) const;
    [[nodiscard]] double rate(std::span<const double> table, std::size_t columns,
                              std::size_t j) const;
};

/// `sample_times` ascend strictly. Before the first sample the stem is held: the value is that of
/// the first sample and the rate is 0. The cubic never spans the first sample, where the
/// acceleration jumps. An excess over the last sample of 1e-9 of the record is rounding.
[[nodiscard]] TimeStencil time_stencil(std::span<const double> sample_times, double time);

} // namespace culm::measure
