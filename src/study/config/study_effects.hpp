// SPDX-License-Identifier: BSD-3-Clause
// The effects of a study: users' effect files, and the parameters of effects as factors.
#pragma once

#include "physics/effects/selection.hpp"
#include "study/config/parameters.hpp"

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace culm::study {

/// Reads an effect and compiles its formula. Throws core::InputError with file, line and key of
/// everything that is wrong; a mistake in the formula is marked by a caret.
[[nodiscard]] physics::EffectPointer read_effect_file(const std::filesystem::path& file);

/// The same of a text that was read elsewhere; `file` is its name in messages.
[[nodiscard]] physics::EffectPointer read_effect_text(const std::string& source,
                                                      const std::string& file);

/// Effects as they are named on the command line, those in files included:
/// quadratic_drag,clamp_friction(moment_nm=3e-4),./my.toml. Throws core::InputError.
[[nodiscard]] std::vector<physics::SelectedEffect> effects_from(std::string_view text);

/// The effects that a study adds to the published chain. A parameter of one of them is known as
/// "effect.parameter" and has a row like those of the parameter table, in SI units.
class StudyEffects {
  public:
    StudyEffects() = default;
    explicit StudyEffects(std::vector<physics::SelectedEffect> selected);

    [[nodiscard]] const std::vector<physics::SelectedEffect>& selected() const { return selected_; }
    /// The row of that key, or nullptr. Rows live as long as any copy of this object.
    [[nodiscard]] const Parameter* find(std::string_view key) const;
    [[nodiscard]] const std::vector<std::shared_ptr<const EffectParameterRow>>& rows() const {
        return rows_;
    }
    /// The effects with fixed values, and defaults that suit the stem.
    [[nodiscard]] std::vector<physics::ActiveEffect>
    with_defaults(const physics::StemParameters<double>& stem) const;

  private:
    std::vector<physics::SelectedEffect> selected_;
    std::vector<std::shared_ptr<const EffectParameterRow>> rows_;
};

} // namespace culm::study
