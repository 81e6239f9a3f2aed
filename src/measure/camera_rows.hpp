// SPDX-License-Identifier: BSD-3-Clause
// What a camera sees of the chain: the deflection of its curve in fixed image rows.
#pragma once

#include <span>
#include <vector>

namespace culm::measure {

/// Deflection of the stem's axis in the row at `height` above the clamp.
/// `positions` are the spheres' centres, (spheres, dimensions) row-major in metres, axis 0 along
/// the undeformed stem and axis 1 lateral, ordered from the clamp to the tip with axis 0
/// increasing. The row is at a fixed height: the material slides through it, so the curve is
/// interpolated there (a cubic through the four nearest centres). Returns NaN above the tip: the
/// stem is not in that row.
[[nodiscard]] double deflection_in_row(std::span<const double> positions, int dimensions,
                                       double height);

/// The same for several rows; returns one deflection per height.
[[nodiscard]] std::vector<double> deflections_in_rows(std::span<const double> positions,
                                                      int dimensions,
                                                      std::span<const double> heights);

} // namespace culm::measure
