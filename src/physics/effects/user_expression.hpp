// SPDX-License-Identifier: BSD-3-Clause
// A formula that a user wrote, compiled.
#pragma once

#include "physics/user_law.hpp"

#include <memory>
#include <string>
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

} // namespace culm::physics
