// SPDX-License-Identifier: BSD-3-Clause
// Standard deviation of the readings of a measurement, stated or estimated.
#pragma once

#include "fit/chain/observed_recording.hpp"

#include <string>
#include <vector>

namespace culm::fit {

struct ReadingNoise {
    std::vector<double> by_row; ///< (rows), m; empty: only the residuals of a fit determine it
    std::string source;         ///< "stated", or the data of the estimate
    bool is_known = true;       ///< independent of the fit
};

/// The noise of the noise model if there is one. Otherwise the first of these that is available:
/// the stated noise of each reading (the mean square of a row) or of each row; the scatter about
/// each row's mean while the stem was held, over at least 20 degrees of freedom of all rows
/// together; the scatter of the second differences over the last tenth of the record if the motion
/// there is below the noise; none.
[[nodiscard]] ReadingNoise reading_noise(const ObservedRecording& measurement);

/// Noise of each reading over that of its row, (times, rows); empty: 1.
[[nodiscard]] std::vector<double> relative_noise(const measure::Measurement& measurement,
                                                 const std::vector<double>& by_row);

} // namespace culm::fit
