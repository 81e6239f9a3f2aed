// SPDX-License-Identifier: BSD-3-Clause
// The effects of a study, and their parameters as factors that it may sweep.
#pragma once

#include "physics/effects/selection.hpp"
#include "study/parameter_table.hpp"

#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace culm::study {

/// The effects that a study adds to the published chain. A parameter of one of them is known as
/// "effect.parameter" and has a row like those of the parameter table, in SI units.
class StudyEffects {
  public:
    StudyEffects() = default;
    explicit StudyEffects(std::vector<physics::SelectedEffect> selected);

    [[nodiscard]] const std::vector<physics::SelectedEffect>& selected() const { return selected_; }
    /// The row of that key, or nullptr. Rows live as long as any copy of this object.
    [[nodiscard]] const Parameter* find(std::string_view key) const;
    [[nodiscard]] std::vector<std::string> keys() const;
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
