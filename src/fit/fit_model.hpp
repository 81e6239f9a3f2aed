// SPDX-License-Identifier: BSD-3-Clause
// The policy of every fit: where it starts, when it restarts and when it fails.
#pragma once

#include "fit/start/starts.hpp"

#include <optional>
#include <span>
#include <vector>

namespace culm::fit {

/// Fits the published chain, or a model with effects that move a stem which is at rest without
/// them, to all recordings at once. `smaller`: a fit with some or none of the effects; only the
/// chain alone needs none.
///
/// 1. Each recording's own fit comes first; the joint fit starts from them. Both have growing
///    windows, so that no cycle is skipped.
/// 2. A fit that has not converged is continued once. A fit whose steps met a bound is restarted
///    from there.
/// 3. If nothing in the model moves the stem, the readings are the residuals
///    (FitStatus::Motionless).
///
/// Never throws for a model that cannot be fitted or combined, but returns FitStatus::Failed with
/// the reason. Throws run::Abandoned if the heartbeat says so.
[[nodiscard]] Fit fit_model(const SelectedEffects& effects, const Fit& smaller,
                            std::span<const ObservedRecording> recordings,
                            const FitOptions& options = {});

/// Refits `judged`, a fit with the error terms of `recordings`, with every input as stated. The
/// intervals include the uncertainty of the inputs. `smaller` is the published chain, as stated.
[[nodiscard]] Fit as_stated(const Fit& judged, const Fit& smaller,
                            std::span<const ObservedRecording> recordings,
                            const FitOptions& options = {});

/// The published chain, and the recordings with their noise in motion and their error terms: every
/// other model is fitted to these.
struct BaselineFit {
    std::vector<ObservedRecording> recordings;
    Fit fit;                           ///< with the error terms
    Fit stated;                        ///< with every input as stated
    std::vector<RecordingFit> alone{}; ///< (recordings) without errors; empty: nothing moves
};
/// Adds with_reading_errors() about each recording's own fit of the chain, and fits all from there.
/// Recordings in which the chain does not move have no errors. Throws as fit_model().
[[nodiscard]] BaselineFit fit_baseline(std::span<const measure::Measurement> measurements,
                                       const FitOptions& options = {});

/// The baseline with another number of spheres: the same noise in motion, fitted from the numbers
/// of `other`, whose chain is that of `from`.
[[nodiscard]] BaselineFit baseline_with_chain(const BaselineFit& other, const FitOptions& from,
                                              std::span<const measure::Measurement> measurements,
                                              const FitOptions& options);

/// The models of a fit (its numbers suffice) to `from.recordings` with the chain of `options` and
/// the error terms of `recordings`; Y and β keep the first mode of each recording's chain.
[[nodiscard]] StartModels with_chain(const Fit& numbers, std::span<const ObservedRecording> from,
                                     const FitOptions& from_options,
                                     std::span<const ObservedRecording> recordings,
                                     const FitOptions& options);

/// The baseline of `measurements` with the noise in motion about `larger`, a model that explains
/// more than the chain. Empty if the noise about both models is the same.
[[nodiscard]] std::optional<BaselineFit>
baseline_beside_noise_of(const Fit& larger, const BaselineFit& baseline,
                         std::span<const measure::Measurement> measurements,
                         const FitOptions& options = {});

/// Fits a larger model than that of `smaller` from models that are near the solution. If a model
/// that contains the smaller one fits worse, it has skipped a cycle: growing windows are tried. If
/// that does not help, the fit has failed.
[[nodiscard]] Fit refined(const StartModels& start, const SelectedEffects& effects,
                          const Fit& smaller, std::span<const ObservedRecording> recordings,
                          const FitOptions& options);

/// Fits a model to `recordings` with their error terms, from its fits to each recording with other
/// terms or none.
[[nodiscard]] Fit fit_again(const SelectedEffects& effects, std::span<const RecordingFit> from,
                            std::span<const ObservedRecording> recordings,
                            const FitOptions& options);

/// Cost of a run with these effects, relative to the published chain.
[[nodiscard]] double relative_cost(const SelectedEffects& effects);

} // namespace culm::fit
