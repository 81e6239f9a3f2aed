// SPDX-License-Identifier: BSD-3-Clause
// One model of a search: its identity, its plan and its fit.
#pragma once

#include "diagnose/evidence/linear_evidence.hpp"
#include "diagnose/evidence/log_evidence.hpp"
#include "diagnose/policy.hpp"
#include "fit/fit_model.hpp"
#include "fit/fit_numbers.hpp"

#include <limits>
#include <span>
#include <string>
#include <vector>

namespace culm::diagnose {

/// Names of the effects, with fixed values and the recordings where they are absent, sorted.
using ModelKey = std::vector<std::string>;
[[nodiscard]] ModelKey key_of(const fit::SelectedEffects& effects);

/// Can the effects act together? A family whose laws are one law permits at most one effect.
[[nodiscard]] bool can_be_combined(const fit::SelectedEffects& effects);

[[nodiscard]] bool contains_all(const fit::SelectedEffects& effects,
                                const fit::SelectedEffects& some);

/// Effects of models to compare with `fit`: without one of its effects after the first `known`,
/// and with an effect that is absent from one recording (a mass at its tip need not act in all).
[[nodiscard]] std::vector<fit::SelectedEffects>
sets_to_compare(const fit::Fit& fit, std::span<const fit::ObservedRecording> recordings,
                std::size_t known);

inline constexpr double not_predicted = std::numeric_limits<double>::quiet_NaN();

/// A fitted model as a rank returns it.
struct FittedModel {
    fit::Fit fit; ///< its numbers
    ModelEvidence evidence;
    bool is_inadequate = false; ///< it fails the tests for lack of fit
};
template <class Wire>
void fields(Wire& wire, FittedModel& model) {
    fields(wire, model.fit);
    wire(model.evidence, model.is_inadequate);
}

/// A model to be fitted.
struct PlannedModel {
    fit::SelectedEffects effects;
    double predicted = not_predicted;
    std::vector<fit::StartModels> starts; ///< along the way of a prediction, or one near the end
};

/// Models of the recordings on the way to the linear estimate: with the effects `chosen` among
/// `views`, and with the sizes of `gain` and the changes of the base's own parameters multiplied by
/// 1, 1/4, 1/16 and 0. Locations are those of `gain`.
[[nodiscard]] std::vector<fit::StartModels>
starts_to_estimate(const fit::Fit& base, std::span<const fit::ObservedRecording> recordings,
                   const std::vector<CandidateView>& views, const LinearEvidence& linear,
                   const std::vector<std::size_t>& chosen, PredictedGain gain);

/// Adds the effects to `smaller` together and one by one, the one that is predicted to explain most
/// first, each time from the linear estimate about the fit before; the better fit counts. If
/// nothing moves in `smaller`, as fit::fit_model(). Never throws for a model that cannot be fitted
/// or combined, but returns FitStatus::Failed with the reason.
[[nodiscard]] fit::Fit fit_larger(const fit::SelectedEffects& effects, const fit::Fit& smaller,
                                  std::span<const fit::ObservedRecording> recordings,
                                  const fit::FitOptions& options = {});

/// Fits from the best of the plan's starts or, if there is none, as fit_larger(). `smaller`: a
/// fitted model with some of the effects.
[[nodiscard]] FittedModel fit_planned(const PlannedModel& planned, const fit::Fit& smaller,
                                      std::span<const fit::ObservedRecording> recordings,
                                      const fit::SelectedEffects& known, const Policy& policy,
                                      const fit::FitOptions& options);

} // namespace culm::diagnose
