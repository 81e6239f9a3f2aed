// SPDX-License-Identifier: BSD-3-Clause
// The policy of every fit: where it starts, when it restarts and when it fails.
#pragma once

#include "fit/start/starts.hpp"

#include <optional>
#include <span>
#include <vector>

namespace culm::fit {

/// Fits `effects` in addition to the published chain (none: the chain alone) to all recordings at
/// once. `smaller`: a fit with some or none of the effects; only the chain alone needs none.
///
/// 1. The chain alone, and a model that moves a stem which is at rest without its effects, start
///    from each recording's own fit, with growing windows so that no cycle is skipped. Shared
///    parameters start from the mean of the recordings' values and, where the mean would put the
///    recordings out of phase, from the values of each recording.
/// 2. A larger model starts from candidate_starts() about `smaller` and, for several recordings
///    that disagree, from reconciling_starts(). Each start gets some iterations. The best one is
///    completed, and then the next one if it is already better.
/// 3. A fit that has not converged is continued once. A fit whose steps met a bound is restarted
///    from there.
/// 4. If a larger model that contains the smaller one fits worse, it has skipped a cycle: growing
///    windows are tried from the same starts. If that does not help, the fit has failed.
/// 5. If nothing in the model moves the stem, the readings are the residuals
///    (FitStatus::Motionless).
///
/// Never throws for a model that cannot be fitted or combined, but returns FitStatus::Failed with
/// the reason. Throws run::Abandoned if the heartbeat says so.
[[nodiscard]] Fit fit_model(const SelectedEffects& effects, const Fit& smaller,
                            std::span<const ObservedRecording> recordings,
                            const FitOptions& options = {});

/// A model fitted twice: with every input as stated, and together with the error terms of the
/// readings.
struct ModelFit {
    Fit stated; ///< printed and drawn; intervals include the uncertainty of the inputs
    Fit judged; ///< tested and compared; equals `stated` if the inputs diverge
};

/// Refits `judged`, a fit with the error terms of `recordings`, with every input as stated. The
/// intervals include the uncertainty of the inputs. `smaller` is the published chain, as stated.
[[nodiscard]] Fit as_stated(const Fit& judged, const Fit& smaller,
                            std::span<const ObservedRecording> recordings,
                            const FitOptions& options = {});

/// The published chain, and the recordings with their noise in motion and their error terms: every
/// other model is fitted to these.
struct BaselineFit {
    std::vector<ObservedRecording> recordings;
    Fit fit;                           ///< ModelFit::judged
    Fit stated;                        ///< ModelFit::stated
    std::vector<RecordingFit> alone{}; ///< (recordings) without errors; empty: nothing moves
};
/// Adds with_reading_errors() about each recording's own fit of the chain, and fits all from there.
/// Recordings in which the chain does not move have no errors. Throws as fit_model().
[[nodiscard]] BaselineFit fit_baseline(std::span<const measure::Measurement> measurements,
                                       const FitOptions& options = {});

/// The baseline of `measurements` with the noise in motion about `larger`, a model that explains
/// more than the chain. Empty if the noise about both models is the same.
[[nodiscard]] std::optional<BaselineFit>
baseline_beside_noise_of(const Fit& larger, const BaselineFit& baseline,
                         std::span<const measure::Measurement> measurements,
                         const FitOptions& options = {});

/// Fits the models of `effect_sets`, each of which contains the one before it, by fit_with_parts()
/// with every input as stated and then with the error terms. The published chain is the first. If
/// the noise in motion differs about the last model, all are fitted with that noise. Throws as
/// baseline_model() and candidate_model() if a model cannot be built, before any chain is run.
struct NestedFits {
    std::vector<ObservedRecording> recordings; ///< BaselineFit::recordings
    std::vector<ModelFit> models;
};
[[nodiscard]] NestedFits fit_nested(std::span<const measure::Measurement> measurements,
                                    const std::vector<SelectedEffects>& effect_sets,
                                    const FitOptions& options = {});

/// fit_model() for a model that may add several effects at once. It cannot fit worse than its
/// parts, the models with one of these effects less. If the fit fails, or an effect is at a bound
/// or consistent with zero, the parts are fitted too. If one of them fits better, the fit is
/// restarted from that solution; if it is still worse, it has failed.
[[nodiscard]] Fit fit_with_parts(const SelectedEffects& effects, const Fit& smaller,
                                 std::span<const ObservedRecording> recordings,
                                 const FitOptions& options = {});

/// fit_model() from given models that are near the solution, without other starts.
[[nodiscard]] Fit refined(const StartModels& start, const SelectedEffects& effects,
                          const Fit& smaller, std::span<const ObservedRecording> recordings,
                          const FitOptions& options);

/// Fits a model to `recordings` with their error terms, from its fits to each recording with other
/// terms or none.
[[nodiscard]] Fit fit_again(const SelectedEffects& effects, std::span<const RecordingFit> from,
                            std::span<const ObservedRecording> recordings,
                            const FitOptions& options);

/// Cost of a run with these effects, relative to the published chain. Spatial chains take six times
/// as long.
[[nodiscard]] double relative_cost(const SelectedEffects& effects);

} // namespace culm::fit
