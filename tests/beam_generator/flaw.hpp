// SPDX-License-Identifier: BSD-3-Clause
// Errors of a recording that do not depend on the stem.
#pragma once

#include "beam_generator/recording.hpp"

#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace culm::beam {

struct Flaw {
    std::string name;
    std::function<void(RecordingSpec&)> apply;
};

/// None, then: noise of unstated size, readings rounded to 0.1 mm, outliers, gaps, correlated
/// noise, a stated length that is 1 % too large, a release 0.6 ms late or early, 0.08 s only.
[[nodiscard]] const std::vector<Flaw>& flaws();

/// Throws std::invalid_argument if none has this name.
[[nodiscard]] const Flaw& flaw_named(std::string_view name);

} // namespace culm::beam
