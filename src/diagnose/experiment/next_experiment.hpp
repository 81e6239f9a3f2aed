// SPDX-License-Identifier: BSD-3-Clause
// The experiment that would distinguish effects which this recording cannot distinguish.
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
    /// Squared distance, in standard deviations, between one model's prediction and the closest one
    /// that the other model can reach. Above 25: five sigma.
    double expected_gap = 0.0;
};

/// A model of this recording that cannot be distinguished from another.
struct Rival {
    fit::Fit fit;
    /// An effect whose size is assumed; the other parameters are fitted again with it.
    std::string assumed;
};

/// Simulates each experiment of a list (a known mass at the tip, half and one and a half times the
/// deflection, a shorter stem, a faster camera, a longer record, a vacuum, the reversed stem …)
/// with both models. Computes the smallest distance of the second from the first, with its
/// parameters within the range that this recording allows and its release free. Best first.
[[nodiscard]] std::vector<Experiment>
next_experiments(const std::pair<Rival, Rival>& pair,
                 std::span<const fit::ObservedRecording> recordings, const fit::FitOptions& options,
                 const core::ItemMap& map);

} // namespace culm::diagnose
