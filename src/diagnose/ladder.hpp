// SPDX-License-Identifier: BSD-3-Clause
// Models of growing size fitted to one measurement, and whether each step is a gain.
#pragma once

#include "diagnose/comparison.hpp"
#include "diagnose/held_out.hpp"

#include <optional>
#include <string>
#include <vector>

namespace culm::diagnose {

/// One model on the ladder. Changes and the gain are against the last rung below it that was a
/// gain; the baseline counts as one. What was refused is no yardstick: a useless effect below would
/// otherwise take part of the next one's gain, or lend it some.
struct Rung {
    fit::Fit fit;
    std::size_t compared_with = 0;  ///< place of that rung on the ladder
    std::vector<std::string> added; ///< effects that it does not have
    std::optional<HeldOut> held_out;
    double bic = 0.0;            ///< Bayesian information criterion with effective readings
    double delta_bic = 0.0;      ///< negative: better
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

/// Throws core::InputError if the readings are no more than their noise.
///
/// Fits the baseline and every model of `models`, each of which contains the one before it, from
/// the largest fitted model that it contains.
///
/// BIC = χ²/s · n/N + k ln n with n effective readings (from the correlation of the residuals of
/// the best rung, which is closest to that of the noise), N readings, k fitted numbers, and s the
/// reduced χ² of the best rung if that is above 1: what all models miss alike is noise to them.
///
/// A rung is a gain if the criterion falls by 10 or more, what was held out is predicted better
/// (held_out_obstacle), the interval of one size of each new effect excludes its absence, and none
/// of their parameters stands at a bound. Effects without a fitted parameter need no interval. If
/// rungs below were refused, the criterion must fall by 10 against the uppermost of them too, and
/// new are the effects that it does not have.
[[nodiscard]] Ladder climb(const measure::Measurement& measurement,
                           const std::vector<fit::SelectedEffects>& models,
                           const fit::FitOptions& options = {});

} // namespace culm::diagnose
