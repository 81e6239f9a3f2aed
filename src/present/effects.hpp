// SPDX-License-Identifier: BSD-3-Clause
// The cards of effects for people, for programs and for docs/effects.md.
#pragma once

#include "physics/effects/effect.hpp"

#include <span>
#include <string>

#include <nlohmann/json.hpp>

namespace culm::present {

/// One line for each effect, with the names of its parameters.
[[nodiscard]] std::string effects_list(std::span<const physics::EffectPointer> effects);

/// All properties of one effect, in lines of some 90 characters.
[[nodiscard]] std::string effect_card(const physics::Effect& effect);

/// All properties of each effect as Markdown.
[[nodiscard]] std::string effects_markdown(std::span<const physics::EffectPointer> effects);

/// docs/schemas/effects.schema.json.
[[nodiscard]] nlohmann::json effects_json(std::span<const physics::EffectPointer> effects);

} // namespace culm::present
