// SPDX-License-Identifier: BSD-3-Clause
// The experiment that would tell effects apart which this recording cannot.
#pragma once

#include "core/item_map.hpp"
#include "fit/fit_numbers.hpp"

#include <span>
#include <string>
#include <utility>
#include <vector>

namespace culm::diagnose {

struct Experiment {
    std::string what;                     ///< one sentence, an instruction
    std::vector<std::string> first_model; ///< names, as Fit's, of the models that it distinguishes
    std::vector<std::string> second_model;
    /// Square of the distance, in standard deviations, by which the best that one model can do
    /// misses what the other predicts. Above 25: five sigma.
    double expected_gap = 0.0;
};

/// A model of the recording at hand that others cannot be told from.
struct Rival {
    fit::Fit fit;
    /// An effect whose size is assumed: the other numbers are fitted again beside it.
    std::string assumed;
};

/// Simulates each experiment of a list (a known mass at the tip, half and one and a half times the
/// deflection, a shorter stem, a faster camera, a longer record, a vacuum, the stem turned end for
/// end …) with both models and asks how far the second, its numbers within what the
/// recording at hand allows and its release free, stays away from the first. Best first.
[[nodiscard]] std::vector<Experiment>
next_experiments(const std::pair<Rival, Rival>& pair,
                 std::span<const fit::ObservedRecording> recordings, const fit::FitOptions& options,
                 const core::ItemMap& map);

} // namespace culm::diagnose
