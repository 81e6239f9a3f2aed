// SPDX-License-Identifier: BSD-3-Clause
// Checks every point of a design before any of them is computed.
#pragma once

#include "run/case_spec.hpp"
#include "study/config.hpp"
#include "study/design.hpp"

#include <functional>
#include <optional>
#include <string>

namespace culm::study {

/// What is wrong with a case, or nothing.
using CaseCheck = std::function<std::optional<std::string>(const run::CaseSpec&)>;

/// Checks the constraints of case_constraints.hpp at every point, then `further` (for example the
/// stability of an explicit step). Throws core::InputError with the number of bad points and the
/// first ten of them, each with its factors' values.
void check_points(const StudyConfig& config, const Design& design, const CaseCheck& further = {});

} // namespace culm::study
