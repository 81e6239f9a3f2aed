// SPDX-License-Identifier: BSD-3-Clause
// What a study keeps of each point: the columns of its result table.
#pragma once

#include "archive/point_record.hpp"
#include "archive/study/description.hpp"
#include "reduce/ring_down_fit.hpp"
#include "run/case_result.hpp"
#include "study/config.hpp"

#include <vector>

namespace culm::study {

/// The result columns of a study of this kind, in the order of PointRecord::values.
[[nodiscard]] std::vector<archive::Column> result_columns(const StudyConfig& config);

/// The options of the fit that a study asks for.
[[nodiscard]] reduce::RingDownFitOptions fit_options(const ReduceOptions& options);

/// Sample times of a study's histories, s.
[[nodiscard]] std::vector<double> sample_times(const run::CaseSpec& spec);

/// Fits Eq. 1 to the tip's history and keeps what the study stores. A computed case whose history
/// cannot be fitted fails when nothing but the fit is stored; else its histories are kept and the
/// fit's columns are NaN. `wall_seconds` of the case is not recorded: it differs between runs.
[[nodiscard]] archive::PointRecord make_record(const run::CaseSpec& spec, run::CaseOutcome outcome,
                                               const ReduceOptions& options);

} // namespace culm::study
