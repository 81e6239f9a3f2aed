// SPDX-License-Identifier: BSD-3-Clause
// Models next to a fitted one, and the log evidence of further effects about it, without a fit.
#pragma once

#include "diagnose/evidence/linear_evidence.hpp"
#include "diagnose/models/model_fits.hpp"

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace culm::diagnose {

/// The candidates of a rig, summed over its stems. Sizes are in units of the first stem that shows
/// the candidate.
struct RigView {
    std::vector<EffectColumns> columns; ///< (candidates) without readings
    LinearEvidence linear;
};

/// A fitted model with the effects of all candidates about it.
class Linearised {
  public:
    /// Computes the columns of the candidates on all ranks. `noise` (stems) divides what they show.
    Linearised(const Stems& stems, const Model& base, const std::vector<NoiseScale>& noise);

    /// The view of a stem that was fitted.
    [[nodiscard]] const EffectView& view(std::size_t stem) const { return views_[stem]; }
    [[nodiscard]] const std::map<std::string, RigView>& rigs() const { return rigs_; }
    /// Change of the log evidence of one stem by own effects, with the odds of each; what the
    /// shared numbers imitate is not counted.
    [[nodiscard]] const LinearEvidence& in_stem(std::size_t stem) const { return in_stem_[stem]; }
    /// The effect on a rig with the values of the linear estimate: number `place` of `gain`.
    [[nodiscard]] ActingEffect estimated(const std::string& rig, std::size_t candidate,
                                         std::size_t place, const PredictedGain& gain) const;

  private:
    void compute_views(const Model& base);
    [[nodiscard]] RigView view_of_rig(const std::string& rig, const Model& base,
                                      const std::vector<NoiseScale>& noise) const;

    const Stems* stems_;
    std::vector<EffectView> views_;       ///< (stems)
    std::vector<LinearEvidence> in_stem_; ///< (stems)
    std::map<std::string, RigView> rigs_;
};

/// A model whose log evidence was only predicted.
struct UnvisitedModel {
    std::vector<ActingEffect> effects;
    double log_evidence = 0.0;
    std::size_t base = 0; ///< the visited model about which it was predicted
    std::vector<std::pair<OwnedEffect, double>> added; ///< and the fall of χ² by each alone
};

struct Prediction : UnvisitedModel {
    std::vector<std::size_t> candidates;        ///< added to the model about which it was made
    std::map<std::size_t, PredictedGain> gains; ///< (stems) of own effects
    double gain = 0.0;                          ///< of log evidence over that of the base
    double noise = 1.0;                         ///< mean variance by which it was computed
};

/// The model that adds the candidates of `set` to the rig or, if that is empty, to those stems that
/// need them; a gain of −infinity if none does. Empty: no model has these additions. `about`: the
/// fitted model `base`.
[[nodiscard]] std::optional<Prediction> predicted(const Stems& stems, const Linearised& about,
                                                  const Model& base, const std::string& rig,
                                                  const std::vector<std::size_t>& set);

/// The effects of models that need no prediction: those with one effect less, with an effect that
/// is absent from one recording (a mass at its tip need not act in all), with an effect of stems
/// that a rig has instead, and `with_contained` those with a candidate that an effect contains or
/// excludes in its place.
[[nodiscard]] std::vector<std::vector<ActingEffect>>
neighbours_of(const Model& model, const Stems& stems, bool with_contained);

} // namespace culm::diagnose
