// SPDX-License-Identifier: BSD-3-Clause
// Models of growing size fitted to one measurement, and whether each step is a gain.
#pragma once

#include "diagnose/adequacy.hpp"
#include "fit/solve/residual_statistics.hpp"
#include "fit/start/residual_spectrum.hpp"
#include "residuals/stem_ring_downs.hpp"
#include "residuals/swing.hpp"

#include <optional>
#include <span>
#include <string>
#include <vector>

namespace culm::diagnose {

/// Where, when and how a fitted model fails on its measurement.
struct Comparison {
    std::string id;            ///< of the measurement
    measure::ReadingUnit unit; ///< of its readings as text
    bool moves = true;         ///< false: nothing in the model moves the stem
    Verdict verdict;           ///< on what the error terms leave of the residuals
    double rmse = 0.0;         ///< m
    double noise = 0.0;        ///< m; the residuals' own where it is not known
    double over_noise = 0.0;   ///< root mean square of residual over noise
    std::vector<fit::ResidualGroup> by_height;
    std::vector<fit::ResidualGroup> by_time; ///< thirds
    fit::ResidualSpectrum spectrum;
    residuals::BackbonesOfBoth backbones;
    residuals::StemRingDowns measured_ring_downs; ///< Eq. 1 at every height: b1 along the stem
    residuals::StemRingDowns modelled_ring_downs; ///< of the model at the same times and heights
};

/// `part`: index of the measurement among those of the fit.
[[nodiscard]] Comparison compare(const fit::Fit& fit, std::size_t part,
                                 const measure::Measurement& measurement,
                                 const Policy& policy = {});

/// Fits the models of `effect_sets`, each of which contains the one before it, by fit_larger(). The
/// published chain is the first. If the noise in motion differs about the last model, all are
/// fitted with that noise. Throws as baseline_model() and candidate_model() if a model cannot be
/// built, before any chain is run.
struct NestedFits {
    std::vector<fit::ObservedRecording> recordings; ///< BaselineFit::recordings
    std::vector<fit::Fit> models;
};
[[nodiscard]] NestedFits fit_nested(std::span<const measure::Measurement> measurements,
                                    const std::vector<fit::SelectedEffects>& effect_sets,
                                    const fit::FitOptions& options = {});

/// One model in the ladder. Changes and the gain are relative to the model below it with the
/// largest log evidence.
struct LadderModel {
    fit::Fit fit;
    std::optional<Comparison> comparison; ///< empty: the fit failed
    std::size_t compared_with = 0;        ///< index of that model in the ladder
    std::vector<std::string> added;       ///< effects that it does not have
    double log_evidence = 0.0;            ///< over that of the baseline
    double log_evidence_gain = 0.0;       ///< against `compared_with`
    double modulus_change = 0.0;          ///< of Y, relative
    double damping_change = 0.0;          ///< of β, relative
    bool is_gain = false;
    std::string why; ///< one sentence: why it is a gain, or why not
};

struct Ladder {
    std::vector<LadderModel> models; ///< the baseline first
};

/// Throws core::InputError if the readings are consistent with noise alone.
///
/// Fits the baseline and every set of `effect_sets`. Each set contains the previous one, and its
/// fit starts from the largest fitted model that it contains.
///
/// A model is a gain if its probability, relative to the model below it with the largest log
/// evidence, is at least Policy::held_probability, both with the noise of the best model
/// (log_evidence.hpp). A model without motion, or with an effect that ended absent, is not a gain.
[[nodiscard]] Ladder climb(const measure::Measurement& measurement,
                           const std::vector<fit::SelectedEffects>& effect_sets,
                           const fit::FitOptions& options = {}, const Policy& policy = {});

} // namespace culm::diagnose
