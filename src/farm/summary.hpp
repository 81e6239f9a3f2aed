// SPDX-License-Identifier: BSD-3-Clause
// Reports of a map over batches: its progress and its summary.
#pragma once

#include "core/wire.hpp"
#include "farm/pace.hpp"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace culm::farm {

/// State of a running map; made on rank 0.
struct Progress {
    std::int64_t points_done = 0; ///< completed or failed
    std::int64_t points_total = 0;
    std::int64_t failed = 0;
    double elapsed_s = 0.0;
    std::optional<double> estimated_remaining_s; ///< from the costs; none before the first report
    int ranks = 1;
};

/// A batch whose work function threw.
struct LostBatch {
    std::size_t batch = 0; ///< index in the list given to map
    int rank = 0;          ///< that was computing it
    std::string reason;
    friend bool operator==(const LostBatch&, const LostBatch&) = default;
};

/// Answer of a batch (BatchReport::answer).
struct BatchAnswer {
    std::size_t batch = 0; ///< index in the list given to map
    core::Bytes bytes;
    friend bool operator==(const BatchAnswer&, const BatchAnswer&) = default;
};

/// Result of a map, the same on every rank except for the answers.
struct Summary {
    std::int64_t points_total = 0;
    std::int64_t points_completed = 0;
    std::int64_t points_failed = 0;
    std::int64_t points_lost = 0; ///< in lost batches
    double elapsed_s = 0.0;       ///< wall time of the map on rank 0
    double work_s = 0.0;          ///< sum of BatchReport::seconds over all ranks
    int ranks = 1;
    bool stopped_early = false;  ///< a stop or the deadline left points uncomputed
    bool out_of_time = false;    ///< because of the deadline
    Pace pace;                   ///< FarmOptions::pace with the reports of this map
    std::string failure;         ///< why the farm gave up (full disk …); else empty
    std::vector<LostBatch> lost; ///< ordered by batch
    /// On rank 0 only: of batches that have one, ordered by batch.
    std::vector<BatchAnswer> answers;
    friend bool operator==(const Summary&, const Summary&) = default;
};

/// The answers stay on rank 0, because they may be large.
template <class Wire>
void fields(Wire& wire, Summary& summary) {
    wire(summary.points_total, summary.points_completed, summary.points_failed, summary.points_lost,
         summary.elapsed_s, summary.work_s, summary.ranks, summary.stopped_early,
         summary.out_of_time, summary.pace, summary.failure, summary.lost);
}

} // namespace culm::farm
