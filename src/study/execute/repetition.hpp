// SPDX-License-Identifier: BSD-3-Clause
// A study computed again from its archive, and the differences of its results.
#pragma once

#include "archive/study/file.hpp"
#include "study/execute/plan.hpp"
#include "study/execute/study_folder.hpp"

#include <cstdint>
#include <string>
#include <vector>

namespace culm::study {

/// A column of a table, or a kind of history, in which two archives differ.
struct DifferingNumbers {
    std::string name; ///< of the dataset
    std::string unit;
    std::int64_t points = 0; ///< with a difference
    std::int64_t first_point = 0;
    double largest = 0.0; ///< absolute difference, in the unit
    /// Over the archived number, in a history over its largest one; 0 if that is 0.
    double largest_relative = 0.0;
};

struct Repetition {
    std::int64_t points = 0;   ///< compared
    std::int64_t missing = 0;  ///< in the archive, so there was nothing to compare with
    std::int64_t datasets = 0; ///< columns and kinds of histories compared
    std::vector<std::int64_t> other_outcomes; ///< points completed in only one, or failed otherwise
    std::vector<DifferingNumbers> differing;
    /// Of version, compiler, build, libraries, hosts, ranks, start: name, archived text, text now.
    struct Fact {
        std::string name;
        std::string archived;
        std::string now;
    };
    std::vector<Fact> facts;

    [[nodiscard]] bool is_identical() const { return other_outcomes.empty() && differing.empty(); }
};

/// The study as the archive in the folder describes it: configuration, seed and the texts of all
/// files that it names. Throws core::InputError: no archive, or one whose study this culm
/// interprets differently (with the settings that differ).
[[nodiscard]] Study study_to_repeat(const StudyFolder& folder);

/// Reads the whole archive once, so that no hours are spent on results that cannot be compared.
/// Throws core::InputError: damage, tables or histories of another size.
void require_comparable(const StudyFolder& folder);

/// Compares design, results and histories bit for bit; two values that are not a number are equal.
/// Both archives hold the same study.
[[nodiscard]] Repetition compare_archives(const archive::StudyFile& archived,
                                          const archive::StudyFile& now);

} // namespace culm::study
