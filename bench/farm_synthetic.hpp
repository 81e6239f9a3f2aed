// SPDX-License-Identifier: BSD-3-Clause
// The work that bench_farm distributes: busy waiting of known length, trivial points, real studies.
#pragma once

#include "archive/point_record.hpp"
#include "farm/batch.hpp"
#include "run/case_spec.hpp"

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace culm::bench {

/// 1000 batches of 20 ms on average whose lengths vary as those of a study do (log-normal, half of
/// them between 0.6 and 1.3 times the mean); the expected cost is off by some 20 %.
struct SyntheticWork {
    std::vector<farm::Batch> batches;
    std::vector<double> seconds; ///< (batches)
};
[[nodiscard]] SyntheticWork synthetic_work();

[[nodiscard]] std::vector<farm::Batch> trivial_batches(std::int64_t points);

/// A study of Sobol points in the range of the published design, with about `seconds` of work on
/// one rank of this machine.
[[nodiscard]] std::string study_text(const std::string& store, double seconds);

/// A study of `points` points that stores fits.
[[nodiscard]] std::string trivial_study_text(std::int64_t points);

/// A completed point of such a study, with `columns` results.
[[nodiscard]] archive::PointRecord trivial_record(const run::CaseSpec& spec, std::size_t columns);

/// The largest resident set of this process so far.
[[nodiscard]] double largest_resident_megabytes();

} // namespace culm::bench
