// SPDX-License-Identifier: BSD-3-Clause
// Models of growing size fitted to one measurement, and whether each step is a gain.
#pragma once

#include "diagnose/comparison.hpp"
#include "diagnose/held_out.hpp"

#include <optional>
#include <string>
#include <vector>

namespace culm::diagnose {

/// One model on the ladder. Changes and the gain are against the rung before it.
struct Rung {
    CandidateFit candidate;
    std::vector<std::string> added; ///< effects that the rung before does not have
    std::optional<HeldOut> held_out;
    double bic = 0.0;            ///< Bayesian information criterion with effective readings
    double delta_bic = 0.0;      ///< against the rung before; negative: better
    double modulus_change = 0.0; ///< of Y, relative
    double damping_change = 0.0; ///< of β, relative
    bool is_gain = false;
    std::string why; ///< one sentence: why it is a gain, or why not
};

struct Ladder {
    std::vector<Rung> rungs;         ///< the baseline first
    double effective_readings = 0.0; ///< n of the criterion, the same for all rungs
    std::size_t left_out_row = 0;
    std::vector<Comparison>
        comparisons; ///< of every rung that has a fit, in order; by `comparison`
    std::vector<std::optional<std::size_t>> comparison; ///< (rungs): place in `comparisons`
};

/// Fits the baseline and every model of `models`, each of which contains the one before it.
///
/// BIC = χ²/s · n/N + k ln n with n effective readings (from the correlation of the residuals of
/// the best rung, which is closest to that of the noise), N readings, k fitted numbers, and s the
/// reduced χ² of the best rung if that is above 1: what all models miss alike is noise to them.
///
/// A rung is a gain if the criterion falls by 10 or more, the last third of the time and the height
/// that was left out are both predicted better (predicts_better; the height not worse), the
/// interval of one of its sizes excludes the effect's absence, and none of its parameters stands at
/// a bound. Effects without a fitted parameter need no interval.
[[nodiscard]] Ladder climb(const measure::Measurement& measurement,
                           const std::vector<SelectedEffects>& models,
                           const CandidateOptions& options = {});

} // namespace culm::diagnose
