// SPDX-License-Identifier: BSD-3-Clause
// A histogram whose bins suit the data.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace culm::reduce {

struct Histogram {
    std::vector<double> edges; ///< (bins + 1), ascending, equally wide, multiples of the width
    std::vector<std::size_t> counts; ///< (bins); a value on an inner edge counts to the right
};

/// Bins by the rule of Freedman & Diaconis (1981), 2·IQR/n^(1/3), or that of Sturges (1926) where
/// the quartiles coincide; the width rounded to 1, 2 or 5 times a power of ten, at most 100 bins.
/// All values equal: one bin around them. Values must be finite; no values give no bins.
[[nodiscard]] Histogram make_histogram(std::span<const double> values);

} // namespace culm::reduce
