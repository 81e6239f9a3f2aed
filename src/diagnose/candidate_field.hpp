// SPDX-License-Identifier: BSD-3-Clause
// All candidates beside a model: scored, sifted and fitted, spread over the ranks.
#pragma once

#include "diagnose/diagnosis.hpp"
#include "fit/many_fits.hpp"

#include <cstddef>
#include <limits>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace culm::diagnose {

/// A search forward and the exchanges after it meet the same models again. Sets are the same in any
/// order.
class ModelMemory {
  public:
    /// The best fit of these effects so far; null if there is none that succeeded.
    [[nodiscard]] const fit::Fit* fit_of(const fit::SelectedEffects& effects) const;
    void keep(const fit::SelectedEffects& effects, const fit::Fit& fit);

    /// What candidates promise beside these effects; null if they were not scored.
    [[nodiscard]] const std::vector<EffectScore>*
    scores_beside(const fit::SelectedEffects& effects) const;
    void keep(const fit::SelectedEffects& effects, const std::vector<EffectScore>& scores);

  private:
    using Key = std::vector<std::string>;
    [[nodiscard]] static Key key_of(const fit::SelectedEffects& effects);

    std::map<Key, fit::Fit> fits_;
    std::map<Key, std::vector<EffectScore>> scores_;
};

class CandidateField {
  public:
    CandidateField(std::span<const fit::ObservedRecording> recordings,
                   const DiagnosisOptions& options);

    [[nodiscard]] const fit::SelectedEffects& candidates() const { return candidates_; }
    [[nodiscard]] int runs() const { return runs_; }

    /// The chain with these effects, computed on every rank. Throws core::NumericalError if it
    /// cannot be fitted.
    [[nodiscard]] fit::Fit fit(const fit::SelectedEffects& effects, const fit::Fit& smaller);
    /// The same of a fit that is there already.
    [[nodiscard]] fit::Fit keep(const fit::SelectedEffects& effects, fit::Fit fit);
    [[nodiscard]] fit::Fit restore(const fit::Fit& model);
    /// The same as met before, or else fitted from `smaller`; it may have failed.
    [[nodiscard]] fit::Fit recall(const fit::SelectedEffects& effects, const fit::Fit& smaller);

    /// Every candidate that is not in `effects`, beside `base`, the fit of these effects. Without
    /// draws, as met before if they were.
    [[nodiscard]] std::vector<EffectScore> score(const fit::Fit& base,
                                                 const fit::SelectedEffects& effects, int draws);

    /// `effects` and one candidate more, for those whose score promises at least `least_gain` of χ²
    /// and, if `only_best`, a share of what the best one promises. Where `scores` is empty: for
    /// all.
    [[nodiscard]] std::vector<fit::SelectedEffects> one_more(const fit::SelectedEffects& effects,
                                                             const std::vector<EffectScore>& scores,
                                                             double least_gain,
                                                             bool only_best) const;

    /// `effects`, and one of those behind the first `count` that belong to recordings (a mass at
    /// the tip) leaves one more recording, but never all. Empty for a single recording.
    [[nodiscard]] std::vector<fit::SelectedEffects>
    in_fewer_recordings(const fit::SelectedEffects& effects, std::size_t count) const;

    /// All but the spatial ones that would be fitted in vain: those whose score promises less than
    /// the best of the others gains over `smaller`, and than `gained`. Fits that cannot gain as
    /// much either are not followed to their end.
    [[nodiscard]] std::vector<fit::Fit>
    fit_promising(const std::vector<fit::SelectedEffects>& models,
                  const std::vector<EffectScore>& scores, const fit::Fit& smaller, double gained);

    /// Each model, as met before if it was. Fits whose pace would not bring them near `wanted`, or
    /// near where another is already after a few steps, are not followed to their end.
    [[nodiscard]] std::vector<fit::Fit>
    fit_all(const std::vector<fit::SelectedEffects>& models, const fit::Fit& smaller,
            double wanted_chi_squared = std::numeric_limits<double>::infinity());

    /// The same models; those that were not followed to their end are now, as far as they can come
    /// below `largest_chi_squared`.
    [[nodiscard]] std::vector<fit::Fit>
    followed(std::vector<fit::Fit> models, const fit::Fit& smaller, double largest_chi_squared);

  private:
    [[nodiscard]] const fit::Fit* remembered(const fit::SelectedEffects& effects,
                                             const fit::Fit& smaller, double wanted) const;
    [[nodiscard]] std::vector<fit::Fit> fit_anew(const std::vector<fit::SelectedEffects>& models,
                                                 const fit::Fit& smaller, const fit::FitGoal& goal);

    std::span<const fit::ObservedRecording> recordings_;
    const DiagnosisOptions& options_;
    fit::SelectedEffects candidates_;
    ModelMemory memory_;
    int runs_ = 0;
};

/// All pairs of what the `count` best by their residuals have added last, as far as they go
/// together.
[[nodiscard]] std::vector<fit::SelectedEffects> pairs_of_best(std::vector<fit::Fit> singles,
                                                              std::size_t count);
/// The model that adds this one effect to `known` others; null if there is none.
[[nodiscard]] const fit::Fit* single_of(const std::vector<fit::Fit>& models,
                                        const std::string& effect, std::size_t known);
/// Names of the effects that a model has behind its first `count`.
[[nodiscard]] std::vector<std::string> names_behind(const fit::Fit& model, std::size_t count);
[[nodiscard]] bool can_be_combined(const fit::SelectedEffects& effects);

} // namespace culm::diagnose
