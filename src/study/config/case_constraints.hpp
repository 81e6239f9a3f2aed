// SPDX-License-Identifier: BSD-3-Clause
// Constraints between the parameters of one case, in addition to the range of each.
#pragma once

#include "run/case_spec.hpp"

#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace culm::study {

/// A broken constraint, in the words of the config file.
struct Violation {
    std::string key;     ///< the key with its section, for example "release.tip_deflection_mm"
    std::string value;   ///< in the key's unit
    std::string allowed; ///< what it must be
};

struct CaseConstraint {
    std::span<const std::string_view> keys; ///< every key that influences it, the likeliest first
    std::optional<Violation> (*violation)(const run::CaseSpec&) = nullptr;
};

[[nodiscard]] std::span<const CaseConstraint> case_constraints();

} // namespace culm::study
