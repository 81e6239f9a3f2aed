// SPDX-License-Identifier: BSD-3-Clause
// What a search has already found out about sets of effects.
#pragma once

#include "diagnose/score_test.hpp"
#include "fit/fit_numbers.hpp"
#include "fit/model/stem_model.hpp"

#include <map>
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

} // namespace culm::diagnose
