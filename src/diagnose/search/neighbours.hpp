// SPDX-License-Identifier: BSD-3-Clause
// Models next to a fitted one that need no prediction.
#pragma once

#include "diagnose/models/model.hpp"

#include <vector>

namespace culm::diagnose {

/// The effects of the models with one effect less, with an effect that is absent from one recording
/// (a mass at its tip need not act in all), with an effect of stems that a rig has instead, and
/// `with_contained` those with a candidate that an effect contains or excludes in its place.
[[nodiscard]] std::vector<std::vector<ActingEffect>>
neighbours_of(const Model& model, const Stems& stems, bool with_contained);

} // namespace culm::diagnose
