// SPDX-License-Identifier: BSD-3-Clause
// Models of growing size fitted to one measurement, and whether each step is a gain.
#pragma once

#include "diagnose/comparison.hpp"
#include "diagnose/held_out.hpp"

#include <optional>
#include <string>
#include <vector>

namespace culm::diagnose {

/// One model in the ladder. Changes and the gain are against the last model below it that was
/// accepted; the baseline counts as one. A refused model is not compared with: a useless effect
/// below would otherwise take part of the next one's gain, or lend it some.
struct LadderModel {
    fit::Fit stated; ///< with every input as stated: its numbers and residuals are shown
    fit::Fit fit;    ///< with the error terms of the readings: it is tested and compared
    std::size_t compared_with = 0;  ///< place of that model on the ladder
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
    std::vector<LadderModel> models; ///< the baseline first
    double effective_readings = 0.0; ///< n of the criterion, the same for all models
    std::size_t left_out_row = 0;
    std::vector<Comparison>
        comparisons; ///< of every model that has a fit, in order; by `comparison`
    std::vector<std::optional<std::size_t>> comparison; ///< (models): place in `comparisons`
};

/// Throws core::InputError if the readings are no more than their noise.
///
/// Fits the baseline and every set of `effect_sets`, each of which contains the one before it, from
/// the largest fitted model that it contains.
///
/// Each model is judged (judge.hpp) against the last one below it that was accepted. If models
/// between the two were refused, the criterion must fall as much against the uppermost of them, and
/// only the effects that it does not have must be there.
[[nodiscard]] Ladder climb(const measure::Measurement& measurement,
                           const std::vector<fit::SelectedEffects>& effect_sets,
                           const fit::FitOptions& options = {}, const Policy& policy = {});

} // namespace culm::diagnose
