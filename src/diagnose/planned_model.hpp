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
    /// As starts_to_estimate(), or one near the solution; empty: none is known.
    std::vector<fit::StartModels> starts;
};

/// Starts of a model with the effects `chosen` among `views`, as fit::fit_near() takes them: the
/// linear estimate of each point of `gain`, a quarter of the way to the likeliest one, and last the
/// model without the effects. Y and β keep the first mode of the straight way (fit::in_valley()).
[[nodiscard]] std::vector<fit::StartModels>
starts_to_estimate(const fit::Fit& base, std::span<const fit::ObservedRecording> recordings,
                   const std::vector<CandidateView>& views, const std::vector<std::size_t>& chosen,
                   const PredictedGain& gain);

/// Adds the effects to `smaller` from the linear estimate about it. If nothing moves in `smaller`,
/// as fit::fit_model(). Never throws for a model that cannot be fitted or combined, but returns
/// FitStatus::Failed with the reason.
[[nodiscard]] fit::Fit fit_larger(const fit::SelectedEffects& effects, const fit::Fit& smaller,
                                  std::span<const fit::ObservedRecording> recordings,
                                  const fit::FitOptions& options = {});

/// Fits from the plan's starts or, if there are none, as fit_larger(). `smaller`: a
/// fitted model with some of the effects.
[[nodiscard]] FittedModel fit_planned(const PlannedModel& planned, const fit::Fit& smaller,
                                      std::span<const fit::ObservedRecording> recordings,
                                      const fit::SelectedEffects& known, const Policy& policy,
                                      const fit::FitOptions& options);

} // namespace culm::diagnose
