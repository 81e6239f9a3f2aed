// SPDX-License-Identifier: BSD-3-Clause
// The numbers of a model that misses its readings by more than noise.
#pragma once

#include "fit/fit_model.hpp"

#include <optional>
#include <span>
#include <vector>

namespace culm::diagnose {

/// Where a model misses its readings, the misses of neighbouring frames are alike. Least squares
/// counts each for itself: a creeping zero then pulls at every number as hard as the swing does,
/// and the intervals are far too narrow.
struct CorrelatedEstimate {
    std::vector<fit::FittedParameter> parameters; ///< as the fit's, with new values
    std::vector<std::vector<double>> correlation; ///< (recordings)(rows) of neighbouring frames
};

/// The fit's numbers by generalised least squares (Cochrane & Orcutt 1949, from readings after the
/// release): the misses of a row are correlated noise of the first order whose correlation and size
/// are estimated with them; standard errors by frames (covariance_by_frames). Nothing if the chain
/// fails on the way, or if no row's misses are correlated: then the fit says it all.
[[nodiscard]] std::optional<CorrelatedEstimate>
correlated_estimate(const fit::Fit& fit, std::span<const measure::Measurement> recordings,
                    const fit::FitOptions& options = {});

} // namespace culm::diagnose
