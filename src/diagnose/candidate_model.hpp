// SPDX-License-Identifier: BSD-3-Clause
// A model of a measured stem with effects beside the published chain.
#pragma once

#include "calibrate/stem_model.hpp"
#include "measure/folder/measurement.hpp"
#include "physics/effects/selection.hpp"

#include <span>
#include <string>
#include <vector>

namespace culm::diagnose {

using SelectedEffects = std::vector<physics::SelectedEffect>;

/// The same effects in the library's order, users' behind them by name: nothing that is found
/// depends on the order in which effects are named.
[[nodiscard]] SelectedEffects in_library_order(SelectedEffects effects);

/// "baseline", then the effects' names in the given order.
[[nodiscard]] std::vector<std::string> model_names(const SelectedEffects& effects);

/// `baseline`, with its values, and the effects, with the defaults that suit the stem; their
/// parameters are free unless the user fixed them, within the bounds that suit the stem. Throws
/// core::InputError if the effects cannot be combined, or gravity has no direction.
[[nodiscard]] calibrate::StemModel candidate_model(const calibrate::StemModel& baseline,
                                                   const SelectedEffects& effects,
                                                   const measure::Measurement& measurement);

/// Has every effect a size that a fit can make vanish, so that the model contains the one without?
[[nodiscard]] bool is_nested(const calibrate::StemModel& model);

/// Was the stem pulled aside, or do these effects move one that is held straight: gravity across
/// it, a curvature of its own, a moving support, or a user's law?
[[nodiscard]] bool can_move(const calibrate::StemModel& model,
                            const measure::Measurement& recording);

/// Is there a number of it that a fit can change?
[[nodiscard]] bool has_fitted_number(const physics::Effect& effect);

/// The candidates that make sense: gravity only where its direction is known.
[[nodiscard]] SelectedEffects candidate_effects(std::span<const measure::Measurement> recordings);

} // namespace culm::diagnose
