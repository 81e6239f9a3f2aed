// SPDX-License-Identifier: BSD-3-Clause
// Predicted log evidence of effects about a fitted model, in each stem and on each rig.
#pragma once

#include "diagnose/evidence/linear_evidence.hpp"
#include "diagnose/models/model_fits.hpp"

#include <map>
#include <string>
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

} // namespace culm::diagnose
