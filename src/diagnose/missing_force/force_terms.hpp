// SPDX-License-Identifier: BSD-3-Clause
// Simple forces of which a missing force may consist.
#pragma once

#include "fit/model/stem_model.hpp"
#include "physics/effects/user_effect.hpp"

#include <string>
#include <vector>

namespace culm::diagnose {

/// Powers and products of the variables of a user's law, without the terms that the chain already
/// contains (a moment in proportion to the curvature and to its rate).
[[nodiscard]] std::vector<std::string> force_terms(physics::UserLawKind kind);

/// The sum of the terms, each with its own coefficient (c1, c2, …), as a user's effect with the
/// name "missing_force"; `values` are the defaults, `scales` their typical sizes.
[[nodiscard]] physics::UserEffectText force_text(physics::UserLawKind kind,
                                                 const std::vector<std::string>& terms,
                                                 const std::vector<double>& values,
                                                 const std::vector<double>& scales);

/// Coefficients for which each term, at the largest motion of a stem, is about a thousandth of the
/// elastic forces.
[[nodiscard]] std::vector<double> term_scales(physics::UserLawKind kind,
                                              const std::vector<std::string>& terms,
                                              const run::CaseSpec& spec);

/// The value of a term at a point of the stem; throws core::InputError if the term is invalid.
[[nodiscard]] double term_value(physics::UserLawKind kind, const std::string& term,
                                const physics::UserLawInputs& inputs);

/// TOML file of a user's effect.
[[nodiscard]] std::string as_effect_file(const physics::UserEffectText& text);

} // namespace culm::diagnose
