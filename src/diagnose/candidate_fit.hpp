// SPDX-License-Identifier: BSD-3-Clause
// A model with effects fitted to a measurement, from several starts.
#pragma once

#include "calibrate/chain_fit.hpp"
#include "diagnose/candidate_model.hpp"

#include <optional>
#include <string>
#include <vector>

namespace culm::diagnose {

struct CandidateOptions {
    calibrate::ChainOptions chain;
    std::optional<double> window; ///< only frames up to here, s after the release; empty: all
    run::Heartbeat heartbeat;
    std::optional<double> wanted_chi_squared = std::nullopt; ///< as calibrate::ChainFitOptions'
};

struct CandidateFit {
    std::vector<std::string> names; ///< "baseline" and the effects, in the library's order
    std::optional<calibrate::ChainFit> fit;
    std::string failure; ///< why there is no fit
    bool moves = true;   ///< false: nothing in the model moves the stem, so nothing was fitted
    int starts = 0;
    int runs = 0; ///< of the chain with all its derivatives
};

/// The published chain. A stem that was held straight does not move in it: its residuals are the
/// readings themselves.
[[nodiscard]] CandidateFit fit_baseline(const measure::Measurement& measurement,
                                        const CandidateOptions& options = {});

/// The baseline and these effects, from the starts of fit_starts() about `smaller`, a fit of a
/// model with some or none of them; of several the one that is best after some iterations is
/// followed to the end. If the larger model contains the smaller one and fits worse, the solution
/// has missed a cycle, and growing windows are tried. A fit that does not converge, or stays worse
/// than the model that it contains, is a failure and no result. Throws core::InputError if the
/// effects cannot be combined or applied.
[[nodiscard]] CandidateFit fit_candidate(const SelectedEffects& effects,
                                         const CandidateFit& smaller,
                                         const measure::Measurement& measurement,
                                         const CandidateOptions& options = {});

} // namespace culm::diagnose
