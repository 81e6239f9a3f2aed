// SPDX-License-Identifier: BSD-3-Clause
// An effect that a user defines by a formula.
#pragma once

#include "physics/effects/effect.hpp"

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace culm::physics {

/// Definition of an effect by a user.
struct UserEffectText {
    std::string name; ///< lower-case letters, digits and underscores; none of the library's
    std::string summary;
    std::string source;    ///< may be empty, as the three below
    std::string signature; ///< in a recording
    std::string remedy;
    std::string energy; ///< that it stores, dissipates or supplies
    UserLawKind kind = UserLawKind::ForcePerLength;
    std::string formula; ///< of expression_variables(kind) and the parameters
    std::vector<EffectParameter> parameters;
};

/// "force_per_length", "bending_moment", "base_moment".
[[nodiscard]] std::vector<std::string> user_law_kind_names();
[[nodiscard]] std::optional<UserLawKind> user_law_kind(std::string_view name);

/// The fault in the name of an effect or of a parameter; empty if there is none.
[[nodiscard]] std::string effect_name_fault(std::string_view name);
[[nodiscard]] std::string parameter_name_fault(std::string_view name, UserLawKind kind);

/// Compiles the formula and tries it at rest and at typical motions, with the parameters at their
/// defaults and bounds. Throws core::InputError: a mistake in the formula (user_expression.hpp) or
/// a value there that is not a number.
[[nodiscard]] EffectPointer make_user_effect(UserEffectText text);

} // namespace culm::physics
