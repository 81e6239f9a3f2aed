// SPDX-License-Identifier: BSD-3-Clause
// How good the answers of many diagnoses were, as Markdown tables.
#pragma once

#include "beam_generator/random_case.hpp"
#include "bench/diagnosis_outcome.hpp"

#include <string>
#include <string_view>
#include <vector>

namespace culm::bench {

/// What an answer is worth, beside the truth.
enum class Grade {
    Right,     ///< exactly the hidden effects, by name; adequate where there are none
    Family,    ///< of each hidden effect, and of nothing else, the member left open
    HonestTie, ///< a tie, or names with rivals, that together hold every hidden effect
    Partly,    ///< of two hidden effects one, and nothing else
    Silent,    ///< adequate though something is hidden
    Unknown,   ///< "unknown"; right if the library lacks the effect
    WrongTie,  ///< a tie that does not hold the truth
    Wrong,     ///< names that are not hidden there, with confidence
    Failed     ///< no answer
};
inline constexpr int grade_count = 9;
[[nodiscard]] std::string_view to_string(Grade grade);

struct GradedCase {
    beam::RandomCase drawn;
    Outcome outcome;
    Grade grade = Grade::Failed;
};

[[nodiscard]] Grade grade(const beam::RandomCase& drawn, const Outcome& outcome);

/// Upper bound of the one-sided 95 % interval of a rate (Clopper & Pearson 1934).
[[nodiscard]] double upper_bound(int hits, int trials);

/// Tables of each kind that was drawn.
[[nodiscard]] std::string report(const std::vector<GradedCase>& cases);

} // namespace culm::bench
