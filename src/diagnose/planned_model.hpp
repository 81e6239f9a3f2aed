// SPDX-License-Identifier: BSD-3-Clause
// One model of a search: its identity, its plan and its fit.
#pragma once

#include "diagnose/evidence/linear_evidence.hpp"
#include "diagnose/evidence/log_evidence.hpp"
#include "fit/fit_model.hpp"
#include "fit/fit_numbers.hpp"

#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace culm::diagnose {

/// Names of the effects, with fixed values and the recordings where they are absent, sorted.
using ModelKey = std::vector<std::string>;
[[nodiscard]] ModelKey key_of(const fit::SelectedEffects& effects);

/// Can the effects act together? A family whose laws are one law permits at most one effect.
[[nodiscard]] bool can_be_combined(const fit::SelectedEffects& effects);

/// The only law that the general one's 95 % interval in `fit` contains; the name of the general law
/// if it contains none or several. A bound that keeps away from a law is part of the interval.
[[nodiscard]] std::string special_case_of(const physics::Effect& general, const fit::Fit& fit);

[[nodiscard]] bool contains_all(const fit::SelectedEffects& effects,
                                const fit::SelectedEffects& some);

/// Effects of models to compare with `fit`: without one of its effects after the first `known`,
/// with a special case of a general law, and with an effect that is absent from one recording (a
/// mass at its tip need not act in all).
[[nodiscard]] std::vector<fit::SelectedEffects>
sets_to_compare(const fit::Fit& fit, std::span<const fit::ObservedRecording> recordings,
                std::size_t known, const fit::SelectedEffects& candidates);

/// The numbers of the fit, without those of the effects `names`.
[[nodiscard]] fit::Fit without(fit::Fit fit, const std::vector<std::string>& names);

inline constexpr double not_predicted = std::numeric_limits<double>::quiet_NaN();

/// A fitted model as a rank returns it.
struct FittedModel {
    fit::Fit fit;
    ModelEvidence evidence;
};
template <class Wire>
void fields(Wire& wire, FittedModel& model) {
    fields(wire, model.fit);
    wire(model.evidence);
}

/// A model to be fitted.
struct PlannedModel {
    fit::SelectedEffects effects;
    double predicted = not_predicted;
    std::optional<fit::StartModels> start; ///< where the linear estimate leads; none: all starts
};

/// The models of the recordings with the effects `chosen` among `views`, with the sizes and
/// locations of `gain`, and with the other parameters of `base` changed accordingly.
[[nodiscard]] fit::StartModels
start_at_estimate(const fit::Fit& base, std::span<const fit::ObservedRecording> recordings,
                  const std::vector<CandidateView>& views, const LinearEvidence& linear,
                  const std::vector<std::size_t>& chosen, const PredictedGain& gain);

/// Fits from the plan's start or, if there is none or it fails, from all starts of
/// fit_with_parts(). A model that leaves the plane is first fitted by planar chains
/// (fit/model/superposition.hpp). `smaller`: a fitted model with some of the effects.
[[nodiscard]] FittedModel fit_planned(const PlannedModel& planned, const fit::Fit& smaller,
                                      std::span<const fit::ObservedRecording> recordings,
                                      const fit::SelectedEffects& known,
                                      const fit::FitOptions& options);

} // namespace culm::diagnose
