// SPDX-License-Identifier: BSD-3-Clause
// Checks every point of a design before any of them is computed.
#pragma once

#include "farm/batch.hpp"
#include "run/case_spec.hpp"
#include "study/config/study_config.hpp"
#include "study/design/design.hpp"

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace culm::study {

/// Returns the fault of a case, or nothing.
using CaseCheck = std::function<std::optional<std::string>(const run::CaseSpec&)>;

/// The values of a point's factors, " (bond_damping = 25, …)"; empty without factors.
[[nodiscard]] std::string factors_text(const Design& design, std::int64_t point);

/// Checks the constraints between parameters (violations_of) at every point, then `further` (for
/// example the stability of an explicit step). Throws core::InputError with the number of bad
/// points and the first ten of them, each with its factors' values.
void check_points(const StudyConfig& config, const Design& design, const CaseCheck& further = {});

/// A validated study: configuration and design belong together.
struct Study {
    StudyConfig config;
    Design design;
};

/// Loads, generates and checks everything, the stability of explicit steps included.
/// Throws core::InputError with every complaint.
[[nodiscard]] Study load_study(const std::filesystem::path& file);
/// A file in `files` is not looked for on the disk.
[[nodiscard]] Study parse_study(std::string_view text, const std::string& file,
                                const StudyFiles& files = {});

/// Expected computing time of a case on one core of the reference machine, s. Only ratios matter
/// for the schedule; the order of magnitude is for people (docs/performance.md).
[[nodiscard]] double estimated_seconds(const run::CaseSpec& spec);

/// The given points in batches of one implicit case, or of one explicit case for each lane of the
/// machine; explicit points are grouped so that the lanes of a batch can run together. Points that
/// are also in `alone` (ascending) get their own batches.
[[nodiscard]] std::vector<farm::Batch> make_batches(const Study& study,
                                                    const std::vector<std::int64_t>& points,
                                                    const std::vector<std::int64_t>& alone = {});

/// Expected cost of a run.
struct Estimate {
    std::int64_t points = 0;
    std::int64_t batches = 0;
    std::size_t lanes = 1; ///< cases side by side in one batch
    double core_seconds = 0.0;
    double archive_bytes = 0.0; ///< of the study file, before compression
    double memory_bytes_per_rank = 0.0;
};
[[nodiscard]] Estimate estimate(const Study& study, const std::vector<farm::Batch>& batches);

} // namespace culm::study
