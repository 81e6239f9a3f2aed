// SPDX-License-Identifier: BSD-3-Clause
// Intervals by the likelihood profile: how far a parameter can go while all others make up for it.
#pragma once

#include "fit/solve/fit.hpp"

#include <string>
#include <vector>

namespace culm::calibrate {

struct ProfileInterval {
    std::string name;
    double lower = 0.0; ///< NaN if the profile does not rise enough within the allowed range
    double upper = 0.0;
    int runs = 0;
};

/// 95 % intervals of every fitted parameter: where χ² with the parameter held and all others
/// refitted exceeds the smallest one by 3.84, times the reduced χ² where that is above 1. Each end
/// is found to 2 % of the distance by secants on the signed root of the excess, which is a straight
/// line for a linear model. Of a robust fit the profile is that of the plain sum of squares.
[[nodiscard]] std::vector<ProfileInterval>
profile_intervals(const fit::RecordingFit& fit, const measure::Measurement& measurement,
                  const fit::SolveOptions& options = {});

} // namespace culm::calibrate
