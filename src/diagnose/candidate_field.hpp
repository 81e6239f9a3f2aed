// SPDX-License-Identifier: BSD-3-Clause
// All candidates beside a model: scored, sifted and fitted, spread over the ranks.
#pragma once

#include "diagnose/candidate_fits.hpp"
#include "diagnose/diagnosis.hpp"
#include "diagnose/model_memory.hpp"

#include <cstddef>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace culm::diagnose {

/// A set of effects with its fit.
struct SearchedModel {
    SelectedEffects effects;
    FitSummary fit;
};

class CandidateField {
  public:
    CandidateField(std::span<const measure::Measurement> recordings,
                   const DiagnosisOptions& options);

    [[nodiscard]] const SelectedEffects& candidates() const { return candidates_; }
    [[nodiscard]] int runs() const { return runs_; }

    /// The chain with these effects, computed on every rank. Throws core::NumericalError if it
    /// cannot be fitted.
    [[nodiscard]] ModelFit fit(const SelectedEffects& effects, const ModelFit& smaller);
    [[nodiscard]] ModelFit restore(const SearchedModel& model);
    /// The same as met before, or else fitted from `smaller`; it may have failed.
    [[nodiscard]] ModelFit recall(const SelectedEffects& effects, const ModelFit& smaller);

    /// Every candidate that is not in `effects`, beside `base`, the fit of these effects. Without
    /// draws, as met before if they were.
    [[nodiscard]] std::vector<EffectScore> score(const ModelFit& base,
                                                 const SelectedEffects& effects, int draws);

    /// `effects` and one candidate more, for those whose score promises at least `least_gain` of χ²
    /// and, if `only_best`, a share of what the best one promises. Where `scores` is empty: for
    /// all.
    [[nodiscard]] std::vector<SelectedEffects> one_more(const SelectedEffects& effects,
                                                        const std::vector<EffectScore>& scores,
                                                        double least_gain, bool only_best) const;

    /// `effects`, and one of those behind the first `count` that belong to recordings (a mass at
    /// the tip) leaves one more recording, but never all. Empty for a single recording.
    [[nodiscard]] std::vector<SelectedEffects> in_fewer_recordings(const SelectedEffects& effects,
                                                                   std::size_t count) const;

    /// All but the spatial ones that would be fitted in vain: those whose score promises less than
    /// the best of the others gains over `smaller`, and than `gained`. Fits that cannot gain as
    /// much either are not followed to their end.
    [[nodiscard]] std::vector<SearchedModel>
    fit_promising(const std::vector<SelectedEffects>& models,
                  const std::vector<EffectScore>& scores, const ModelFit& smaller, double gained);

    /// Each model, as met before if it was. Fits whose pace would not bring them near `wanted`, or
    /// near where another is already after a few steps, are not followed to their end.
    [[nodiscard]] std::vector<SearchedModel>
    fit_all(const std::vector<SelectedEffects>& models, const ModelFit& smaller,
            double wanted_chi_squared = std::numeric_limits<double>::infinity());

    /// The same models; those that were not followed to their end are now, as far as they can come
    /// below `largest_chi_squared`.
    [[nodiscard]] std::vector<SearchedModel> followed(std::vector<SearchedModel> models,
                                                      const ModelFit& smaller,
                                                      double largest_chi_squared);

  private:
    [[nodiscard]] const FitSummary* remembered(const SelectedEffects& effects,
                                               const ModelFit& smaller, double wanted) const;
    [[nodiscard]] std::vector<SearchedModel> fit_anew(const std::vector<SelectedEffects>& models,
                                                      const ModelFit& smaller, const FitGoal& goal);
    [[nodiscard]] CandidateOptions with(const run::Heartbeat& heartbeat) const;

    std::span<const measure::Measurement> recordings_;
    const DiagnosisOptions& options_;
    SelectedEffects candidates_;
    ModelMemory memory_;
    int runs_ = 0;
};

[[nodiscard]] bool contains(const SelectedEffects& effects, const physics::SelectedEffect& wanted);
/// All pairs of what the `count` best by their residuals have added last, as far as they go
/// together.
[[nodiscard]] std::vector<SelectedEffects> pairs_of_best(std::vector<SearchedModel> singles,
                                                         std::size_t count);
/// The model that adds this one effect to `known` others; null if there is none.
[[nodiscard]] const SearchedModel* single_of(const std::vector<SearchedModel>& models,
                                             const std::string& effect, std::size_t known);
[[nodiscard]] bool can_be_combined(const SelectedEffects& effects);

} // namespace culm::diagnose
