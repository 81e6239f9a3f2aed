// SPDX-License-Identifier: BSD-3-Clause
// The error of dividing a stem into spheres, of order 2 in the bond length.
//
// With y_N the readings of a chain of N bonds and y_2N those of bonds half as long, Y and β matched
// so that the first mode stays, the stem's are y_N + α (y_2N − y_N), α = 4/3 ± 1/3: the value of
// order 2 and its doubt. The difference is computed about one fit and is the same for all models.
// It is not run if the second frequency changes by less than 0.3 standard deviations of the
// recording, σ_f = √(6/n) σ/(π A T) (Montgomery & O'Donoghue 1999).
#pragma once

#include "fit/solve/fit_result.hpp"

#include <optional>
#include <vector>

namespace culm::fit {

struct Division {
    std::vector<double> known;      ///< (times, heights) of the fit, m; empty: negligible
    std::optional<ErrorTerm> doubt; ///< of what is known
    int batches = 0;
};

/// About the published chain without error terms. `noise_model` may be null. Throws as
/// predict_readings().
[[nodiscard]] Division division_of(const RecordingFit& fit, const NoiseModel* noise_model,
                                   const run::Heartbeat& heartbeat);

} // namespace culm::fit
