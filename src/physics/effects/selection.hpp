// SPDX-License-Identifier: BSD-3-Clause
// Effects as users name them, for example quadratic_drag,clamp_friction(moment_nm=3e-4),./my.toml.
#pragma once

#include "physics/effects/effect.hpp"

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace culm::physics {

/// An effect that a user asked for; a value for each parameter that the user fixed.
struct SelectedEffect {
    EffectPointer effect;
    std::vector<std::optional<double>> fixed;  ///< in the order of effect->parameters
    std::vector<std::string> absent_from = {}; ///< ids of recordings in which it does not act
};

/// Reads a user's effect from a file; throws core::InputError.
using EffectFileReader = std::function<EffectPointer(const std::string& file)>;

/// One effect: NAME, NAME(parameter=value,…), or the same with a file, known by its ending .toml,
/// in place of the name. Throws core::InputError with the nearest name, the position or the bounds.
[[nodiscard]] SelectedEffect parse_effect(std::string_view text, const EffectFileReader& read);

/// Several of them with commas between; combinations are checked. Empty text: none.
[[nodiscard]] std::vector<SelectedEffect> parse_effects(std::string_view text,
                                                        const EffectFileReader& read);

/// The same without a check of combinations: the effects are alternatives.
[[nodiscard]] std::vector<SelectedEffect> parse_alternatives(std::string_view text,
                                                             const EffectFileReader& read);

/// As parse_effect and parse_effects write it again, with the fixed values.
[[nodiscard]] std::string to_string(const SelectedEffect& selected);

/// Does the text name a file rather than an effect of the library?
[[nodiscard]] bool is_effect_file(std::string_view name);

/// The fixed values, and defaults that suit `stem` for the other parameters.
[[nodiscard]] ActiveEffect with_defaults(const SelectedEffect& selected,
                                         const StemParameters<double>& stem);

} // namespace culm::physics
