// SPDX-License-Identifier: BSD-3-Clause
// The work on one stem of a laboratory: its published chain, its fit with given effects of the rig,
// and the changes by further effects. Each function is an item that any rank can compute.
#pragma once

#include "diagnose/evidence/effect_columns.hpp"
#include "diagnose/evidence/log_evidence.hpp"
#include "diagnose/laboratory/shared_block.hpp"
#include "fit/fit_model.hpp"
#include "fit/fit_numbers.hpp"

#include <optional>
#include <span>
#include <string>
#include <vector>

namespace culm::diagnose {

/// A stem with its recordings.
struct Specimen {
    std::string name;
    std::string rig; ///< empty: not stated, so that it shares nothing
    std::vector<measure::Measurement> recordings;
};

/// The recordings by specimen, in the order of first appearance.
/// Throws core::InputError if a specimen was recorded on two rigs.
[[nodiscard]] std::vector<Specimen>
specimens_of(std::span<const measure::Measurement> measurements);

/// The published chain of a specimen, with the noise and the error terms of its readings. It
/// travels between ranks: all ranks have the measurements.
struct StemBaseline {
    std::string failure; ///< why the chain could not be fitted; empty if it could
    std::vector<std::optional<fit::NoiseModel>> noise_models; ///< (recordings)
    std::vector<std::optional<fit::ReadingErrors>> errors;    ///< (recordings)
    std::vector<std::vector<fit::ErrorTerm>> terms;           ///< (recordings)
    fit::Fit chain;                                           ///< numbers
    std::vector<std::vector<double>> noise;                   ///< as JointOptions::noise
};

struct ObservedStem : StemBaseline {
    std::vector<fit::ObservedRecording> recordings; ///< with the noise and the error terms
};

template <class Wire>
void fields(Wire& wire, StemBaseline& baseline) {
    wire(baseline.failure, baseline.noise_models, baseline.errors, baseline.terms, baseline.chain,
         baseline.noise);
}

[[nodiscard]] StemBaseline baseline_of(const Specimen& specimen, const fit::FitOptions& options);
[[nodiscard]] ObservedStem observed_stem(const Specimen& specimen, StemBaseline baseline);
/// The baseline with the noise in motion about `best`, the numbers of a larger model; empty if the
/// noise is the same.
[[nodiscard]] std::optional<StemBaseline> baseline_with_noise_about(const fit::Fit& best,
                                                                    const Specimen& specimen,
                                                                    const ObservedStem& stem,
                                                                    const fit::FitOptions& options);

/// The effects of one stem in a model of the laboratory.
struct StemEffects {
    std::vector<RigEffect> rig; ///< those of its rig
    fit::SelectedEffects known; ///< that the user states, of the stem
    fit::SelectedEffects own;   ///< of the stem
    std::vector<std::string> shared_terms;

    /// All of them, those of the rig with their values fixed.
    [[nodiscard]] fit::SelectedEffects all() const;
    /// Those whose presence is not decided for the stem: the rig's and the known ones.
    [[nodiscard]] fit::SelectedEffects given() const;
};

struct StemFit {
    fit::Fit fit; ///< numbers; the rig's effects are fixed
    ModelEvidence evidence;
    SharedBlock block;
};

template <class Wire>
void fields(Wire& wire, StemFit& stem) {
    wire(stem.fit, stem.evidence, stem.block);
}

/// Fits the stem's own numbers. `from`: numbers of a fit with some of the effects, with its own
/// numbers changed by `change` (as SharedBlock::follow; empty: none).
[[nodiscard]] StemFit fit_stem(const ObservedStem& stem, const StemEffects& effects,
                               const fit::Fit& from, const Eigen::VectorXd& change,
                               const fit::FitOptions& options);

/// The same with own effects that `from` does not have, from all starts of fit_larger().
[[nodiscard]] StemFit fit_stem_from_starts(const ObservedStem& stem, const StemEffects& effects,
                                           const fit::Fit& from, const fit::FitOptions& options);

/// The changes of one stem's readings by all candidates, about a fit.
struct StemSurvey {
    /// (candidates) without readings, for the effects of the rig; the failure says why there is
    /// none.
    std::vector<EffectColumns> rig_columns;
    std::vector<std::vector<ParameterPrior>> priors; ///< (candidates)(free parameters)
    std::vector<std::string> shared; ///< names of the numbers that are shared already
    std::vector<double> shared_at;   ///< (shared)
    /// Of the columns of the candidates, then those of the shared numbers, without what the stem's
    /// own numbers imitate.
    std::vector<double> gram;
    std::vector<double> overlap;
    /// (candidates) change of the log evidence if the effect acts in this stem alone, without prior
    /// odds; −infinity: it cannot.
    std::vector<double> own_gains;
};

template <class Wire>
void fields(Wire& wire, ParameterPrior& prior) {
    wire(prior.is_place, prior.is_one_sided, prior.absent, prior.deviation, prior.range);
}
template <class Wire>
void fields(Wire& wire, StemSurvey& survey) {
    wire(survey.rig_columns, survey.priors, survey.shared, survey.shared_at, survey.gram,
         survey.overlap, survey.own_gains);
}

[[nodiscard]] StemSurvey survey_of(const ObservedStem& stem, const StemEffects& effects,
                                   const fit::Fit& numbers, bool has_rig,
                                   const fit::SelectedEffects& candidates,
                                   const fit::FitOptions& options);

} // namespace culm::diagnose
