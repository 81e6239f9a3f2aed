// SPDX-License-Identifier: BSD-3-Clause
// A formula that a user wrote, and the effect that it defines.
#pragma once

#include "physics/effects/effect.hpp"
#include "physics/user_law.hpp"

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace culm::physics {

/// Names that a formula of this kind may use besides its parameters, in the order of
/// UserLawInputs: s, x, v, kappa, kappa_rate, t; theta, omega, t for a moment at the clamp.
[[nodiscard]] std::vector<std::string> expression_variables(UserLawKind kind);

/// Functions of one number, and min and max of several.
[[nodiscard]] std::vector<std::string> expression_functions();

struct ExpressionText {
    std::string effect; ///< name of the effect, for messages
    UserLawKind kind = UserLawKind::ForcePerLength;
    std::string formula;
    std::vector<std::string> parameters;
};

/// Longest formula, and deepest nesting of its parentheses.
inline constexpr std::size_t longest_formula = 1000;
inline constexpr int deepest_nesting = 50;

/// Compiles the formula once. A mistake throws core::InputError, whose text ends with the formula
/// and a caret under the mistake. Calling the result throws core::NumericalError (UserExpression)
/// with the inputs if the value is not finite; it may be called from several threads.
[[nodiscard]] std::shared_ptr<const UserExpression> compile_expression(const ExpressionText& text);

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
/// defaults and bounds. Throws core::InputError: a mistake in the formula or a
/// value there that is not a number.
[[nodiscard]] EffectPointer make_user_effect(UserEffectText text);

} // namespace culm::physics
