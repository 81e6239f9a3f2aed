// SPDX-License-Identifier: BSD-3-Clause
// The log evidence of a model that adds effects to a fitted one, without a fit.
#pragma once

#include "diagnose/search/linearised.hpp"

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace culm::diagnose {

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

} // namespace culm::diagnose
