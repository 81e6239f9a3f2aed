// SPDX-License-Identifier: BSD-3-Clause
// Standard deviation of the readings of a measurement, stated or estimated.
#pragma once

#include "measure/folder/measurement.hpp"

#include <string>
#include <vector>

namespace culm::fit {

struct ReadingNoise {
    std::vector<double> by_row; ///< (rows), m; empty: only the residuals of a fit can tell
    std::string source;         ///< "stated", or from what it was estimated
};

/// The noise that the measurement states; else the scatter about each row's mean while the stem was
/// held, over at least 20 degrees of freedom of all rows together; else the scatter of the second
/// differences over the last tenth of the record if what is left of the motion there is below the
/// noise; else none.
[[nodiscard]] ReadingNoise reading_noise(const measure::Measurement& measurement);

} // namespace culm::fit
