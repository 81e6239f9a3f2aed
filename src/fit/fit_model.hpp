// SPDX-License-Identifier: BSD-3-Clause
// The policy of every fit: where it starts, when it restarts and when it fails.
#pragma once

#include "fit/fit.hpp"

#include <optional>
#include <span>
#include <vector>

namespace culm::fit {

/// Fits the published chain, or a model with effects that move a stem which is at rest without
/// them, to all recordings at once, from a first guess. `smaller`: a fit with some or none of the
/// effects; only the chain alone needs none. If nothing in the model moves the stem, the readings
/// are the residuals (FitStatus::Motionless).
///
/// Never throws for a model that cannot be fitted or combined, but returns FitStatus::Failed with
/// the reason. Throws run::Abandoned if the heartbeat says so.
[[nodiscard]] Fit fit_model(const SelectedEffects& effects, const Fit& smaller,
                            std::span<const ObservedRecording> recordings,
                            const FitOptions& options = {});

/// Fits a model with these effects from the best of `starts`, as solve() does, or from the last one
/// if that fails. `known`: at the first one; empty: to be computed. A model that contains the
/// smaller one and fits worse has failed.
[[nodiscard]] Fit fit_near(const std::vector<StartModels>& starts, const SelectedEffects& effects,
                           const Fit& smaller, std::span<const ObservedRecording> recordings,
                           const FitOptions& options, std::vector<KnownPoint> known = {});

/// Fits the model of `before` again after a change of the noise or the error terms of the
/// recordings, from its solution. `added` (recordings)(readings): to the predicted readings since
/// then; empty: nothing. `smaller`: as for fit_near().
[[nodiscard]] Fit fit_again(const Fit& before, const Fit& smaller,
                            std::span<const ObservedRecording> recordings,
                            const FitOptions& options,
                            const std::vector<std::vector<double>>& added = {});

/// The published chain, and the recordings with their noise in motion and the error terms that are
/// the same for all models: every other model is fitted to these.
struct BaselineFit {
    std::vector<ObservedRecording> recordings;
    Fit fit;
};

/// 1. The chain is fitted to each recording.
/// 2. The noise in motion, the release, the division of the chain and the errors of place and
///    sensors follow from that.
/// 3. Several recordings, which share Y and β, get factors of these for what their stated inputs
///    leave open, and are fitted together.
/// Recordings in which the chain does not move have no terms. Throws as fit_model().
[[nodiscard]] BaselineFit fit_baseline(std::span<const measure::Measurement> measurements,
                                       const FitOptions& options = {});

/// The baseline with another number of spheres: the same noise in motion, fitted from the numbers
/// of `other`, whose chain is that of `from`.
[[nodiscard]] BaselineFit baseline_with_chain(const BaselineFit& other, const FitOptions& from,
                                              std::span<const measure::Measurement> measurements,
                                              const FitOptions& options);

/// The models of a fit (its numbers suffice) to `from.recordings` with the chain of `options`;
/// Y and β keep the first mode of each recording's chain.
[[nodiscard]] StartModels with_chain(const Fit& numbers, std::span<const ObservedRecording> from,
                                     const FitOptions& from_options,
                                     std::span<const ObservedRecording> recordings,
                                     const FitOptions& options);

/// The baseline of `measurements` with the noise in motion about `larger`, a model that explains
/// more than the chain. Empty if the noise about both models is the same.
[[nodiscard]] std::optional<BaselineFit>
baseline_with_noise_about(const Fit& larger, const BaselineFit& baseline,
                          std::span<const measure::Measurement> measurements,
                          const FitOptions& options = {});

/// The published chain of the recording with its fitted error terms, and these effects.
[[nodiscard]] StemModel observed_model(const SelectedEffects& effects,
                                       const ObservedRecording& recording,
                                       const ChainOptions& options = {});

/// Cost of a fit with these effects, relative to the published chain: runs change each parameter.
[[nodiscard]] double relative_cost(const SelectedEffects& effects);

} // namespace culm::fit
