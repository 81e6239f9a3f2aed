// SPDX-License-Identifier: BSD-3-Clause
// The unit of scheduling: some points of a design that one rank computes together.
#pragma once

#include "farm/heartbeat.hpp"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

namespace culm::farm {

struct Batch {
    std::vector<std::int64_t> points; ///< ids of the points in the study's design
    double cost = 1.0;                ///< expected effort, >= 0, in any unit that all batches share
};

/// What the work function returns. A batch that was left early reports fewer points than it has.
struct BatchReport {
    std::int64_t completed = 0; ///< points with a result
    std::int64_t failed = 0;    ///< points without, their reason recorded by the work function
    double seconds = 0.0;       ///< computing time, s; summed up in the summary
    /// Not empty: why results can no longer be stored. The farm stops as for a StorageError, but
    /// the points of the batch that are counted here have been kept.
    std::string storage_failure = {};
};

/// Computes one batch. An exception means that the batch is lost, see Farm::map.
using Work = std::function<BatchReport(const Batch&, Heartbeat&)>;

/// Order in which the batches (their indices) are handed out: longest first (Graham 1969, "Bounds
/// on multiprocessing timing anomalies": at most 4/3 of the optimal time), ties by the first
/// point's id, then by index. Throws FarmError if a cost is negative or not finite.
[[nodiscard]] std::vector<std::size_t> plan_order(std::span<const Batch> batches);

/// 64-bit FNV-1a hash of all points and costs: tells whether two ranks hold the same list.
[[nodiscard]] std::uint64_t digest(std::span<const Batch> batches);

} // namespace culm::farm
