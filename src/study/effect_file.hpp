// SPDX-License-Identifier: BSD-3-Clause
// Effects that users define in TOML files (docs/effects.md).
#pragma once

#include "physics/effects/selection.hpp"

#include <filesystem>
#include <string_view>
#include <vector>

namespace culm::study {

/// Reads an effect and compiles its formula. Throws core::InputError with file, line and key of
/// everything that is wrong; a mistake in the formula with a caret under its place.
[[nodiscard]] physics::EffectPointer read_effect_file(const std::filesystem::path& file);

/// The same of a text that was read elsewhere; `file` is its name in messages.
[[nodiscard]] physics::EffectPointer read_effect_text(const std::string& source,
                                                      const std::string& file);

/// Effects as they are named on the command line, those in files included:
/// quadratic_drag,clamp_friction(moment_nm=3e-4),./my.toml. Throws core::InputError.
[[nodiscard]] std::vector<physics::SelectedEffect> effects_from(std::string_view text);

} // namespace culm::study
