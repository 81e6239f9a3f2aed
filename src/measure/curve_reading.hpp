// SPDX-License-Identifier: BSD-3-Clause
// One reading of the chain's curve, in an image row or at a mark, with its derivatives.
#pragma once

#include <array>
#include <cstddef>
#include <limits>
#include <span>

namespace culm::measure {

/// Deflection of the chain's curve at one place and its derivatives by the positions of the at most
/// four spheres that it depends on. The curve between the centres is a cubic through four of them;
/// its error is at most 3/128 l⁴ |y''''| between the two inner ones and 1/24 l⁴ |y''''| in the
/// first and last bond, l the bond length: for mode 1 of a cantilever of 56 spheres 6e-8 of the tip
/// deflection, for mode 2 2e-6.
struct CurveReading {
    double deflection = std::numeric_limits<double>::quiet_NaN(); ///< m; NaN: nothing to be seen
    std::size_t first_sphere = 0;
    std::size_t spheres = 0;            ///< 0 if there is nothing to be seen
    std::array<double, 4> by_axial{};   ///< ∂deflection/∂(axial position of first_sphere + k)
    std::array<double, 4> by_lateral{}; ///< the same for the lateral position

    /// Chain rule: derivative of the reading by a parameter, from the derivatives of all positions
    /// by that parameter, laid out as the positions are. 0 if there is nothing to be seen.
    [[nodiscard]] double derivative(std::span<const double> position_derivatives,
                                    int dimensions) const;
};

/// Reads the row at `height` above the clamp. `positions` are the spheres' centres, (spheres,
/// dimensions) row-major in metres, axis 0 along the undeformed stem and axis 1 lateral, from the
/// clamp to the tip with axis 0 increasing. The material slides through the row, so the reading
/// depends on the axial positions too. Nothing is seen below the clamp and above the tip. Where a
/// sphere crosses the row the four spheres change: the reading stays continuous, its derivatives
/// jump by the order of the cubic's error over l.
[[nodiscard]] CurveReading read_row(std::span<const double> positions, int dimensions,
                                    double height);

/// The row's deflection alone, m; NaN where nothing is seen.
[[nodiscard]] double deflection_in_row(std::span<const double> positions, int dimensions,
                                       double height);

/// Reads a mark on the material at `height` along the undeformed stem of which neighbouring centres
/// are `bond_length` apart (m). It does not depend on the axial positions. Nothing is seen off the
/// chain; half a bond beyond the tip's centre still belongs to the chain, for a mark at the very
/// tip must not be lost to rounding.
[[nodiscard]] CurveReading read_mark(std::span<const double> positions, int dimensions,
                                     double bond_length, double height);

} // namespace culm::measure
