// SPDX-License-Identifier: BSD-3-Clause
// The stem's position in every row of one frame, to a fraction of a pixel.
#pragma once

#include "measure/stem_trace.hpp"

#include <array>
#include <vector>

namespace culm::measure {

/// column = a[0] + a[1] t + a[2] t², t = (row − middle)/scale: the paper's preliminary smoothing.
struct HeightQuadratic {
    std::array<double, 3> coefficients{};
    double middle = 0.0;
    double scale = 1.0;
    double deviation = 0.0; ///< robust standard deviation of the row medians about it, pixels

    [[nodiscard]] double at(double row) const {
        const double t = (row - middle) / scale;
        return coefficients[0] + t * (coefficients[1] + t * coefficients[2]);
    }
};

/// Robust least squares through the row medians of a chain (at least 3 runs).
[[nodiscard]] HeightQuadratic fit_quadratic(const std::vector<RowRun>& runs);

/// Column of the stem's axis in every row of the picture, NaN where the stem is not seen or
/// something else is in the way. From the chain's row medians, after rows far from their quadratic
/// are left out (a gate only: no position is replaced by the quadratic), the axis is the middle
/// between the stem's two edges. An edge is where the contrast passes half of what it is inside the
/// stem on that side, refined as the mean of the columns around it weighted by the squared
/// change of intensity. Rows near the tip's end, where the cut through the stem is oblique, and
/// single rows that disagree with their neighbours are left out.
[[nodiscard]] std::vector<double> axis_columns(const BandImage& contrast, const StemChain& chain,
                                               const TraceOptions& options);

} // namespace culm::measure
