// SPDX-License-Identifier: BSD-3-Clause
// Whether a fitted chain explains a measurement, and how sure that is.
#pragma once

#include "calibrate/lack_of_fit.hpp"
#include "diagnose/swing.hpp"

#include <string>
#include <string_view>
#include <vector>

namespace culm::diagnose {

enum class Finding {
    Adequate,   ///< the residuals are noise
    Inadequate, ///< something is missing
    Undecided   ///< the record cannot tell
};

/// "adequate", "inadequate", "undecided".
[[nodiscard]] std::string_view to_string(Finding finding);

struct Verdict {
    Finding finding = Finding::Undecided;
    double p_value = 1.0; ///< the smallest adjusted one
    std::vector<calibrate::LackOfFitTest> tests;
    std::string reason;          ///< which tests object, or why nothing can be said
    double rmse = 0.0;           ///< m
    double noise = 0.0;          ///< m
    bool is_noise_known = false; ///< false: noise is the residuals' own
    double reduced_chi_squared = 0.0;
    double effective_degrees_of_freedom = 0.0;
    double spatial_share = 0.0;          ///< of the residuals' power in one pattern over the rows
    std::vector<double> spatial_pattern; ///< (rows), m, root mean square over the frames
};

/// The tests of calibrate::test_lack_of_fit, with the size judged by the effective degrees of
/// freedom of the residuals' own correlation, and the spatial pattern; together by Holm's
/// adjustment at 1 %. Undecided: fewer than two cycles, a swing below three times its noise, fewer
/// than 30 frames.
[[nodiscard]] Verdict judge(const fit::RecordingFit& fit, const Swing& swing);

} // namespace culm::diagnose
