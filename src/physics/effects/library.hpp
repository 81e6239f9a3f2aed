// SPDX-License-Identifier: BSD-3-Clause
// The library of effects, and the combination of several effects into one model.
#pragma once

#include "physics/effects/effect.hpp"
#include "physics/parameter_id.hpp"

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace culm::physics {

/// The library, in the order in which effects are applied: the stem, the clamp, external
/// loads, the release, the camera. Every call returns the same objects: equal effects have equal
/// pointers.
[[nodiscard]] std::vector<EffectPointer> all_effects();

[[nodiscard]] std::vector<std::string> effect_names();

/// The effect of that name. Throws core::InputError with the nearest name.
[[nodiscard]] EffectPointer effect_named(std::string_view name);

/// Owner of the effect of that name: the stem for users' effects and any other name.
[[nodiscard]] BelongsTo belongs_to(std::string_view name);

/// Throws core::InputError with the reason if an effect occurs twice or one excludes another.
void check_combination(std::span<const EffectPointer> effects);

/// Adds the effects to the target, then adds the target's attached masses to the spheres. The
/// effects are applied in the order of the library (users' effects last), so the model does not
/// depend on the order in which they are named. Values may lie outside their bounds, as the steps
/// of a numerical derivative do; value_fault() is for users' input. Throws core::InputError as
/// check_combination() and the effects do.
void apply_effects(std::span<const ActiveEffect> effects, EffectTarget& target);

/// Text for "effect.parameter = value: must be …", or an empty one if the value is allowed.
[[nodiscard]] std::string value_fault(const Effect& effect, const EffectParameter& parameter,
                                      double value);

} // namespace culm::physics
