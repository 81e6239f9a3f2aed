// SPDX-License-Identifier: BSD-3-Clause
// What a map over batches tells while it runs, and when it is over.
#pragma once

#include "farm/pace.hpp"
#include "farm/wire.hpp"

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
    int ranks = 1;                               ///< that are alive
};

/// A batch that threw, or whose rank died.
struct LostBatch {
    std::size_t batch = 0; ///< index in the list given to map
    int rank = 0;          ///< that was computing it
    std::string reason;
    friend bool operator==(const LostBatch&, const LostBatch&) = default;
};

/// Result of a map, the same on every rank.
struct Summary {
    std::int64_t points_total = 0;
    std::int64_t points_completed = 0;
    std::int64_t points_failed = 0;
    std::int64_t points_lost = 0; ///< in lost batches
    double elapsed_s = 0.0;       ///< wall time of the map on rank 0
    double work_s = 0.0;          ///< sum of BatchReport::seconds over all ranks
    int ranks = 1;
    bool stopped_early = false; ///< a stop or the deadline left points uncomputed
    bool out_of_time = false;   ///< it was the deadline
    Pace pace;                  ///< FarmOptions::pace and what the reports of this map added
    std::string failure; ///< why the farm had to give up (full disk …); empty if it had not
    std::vector<LostBatch> lost; ///< ordered by batch
    std::vector<int> dead_ranks; ///< silent at the end
    friend bool operator==(const Summary&, const Summary&) = default;
};

void put(WireWriter& out, const Summary& summary);
[[nodiscard]] Summary get_summary(WireReader& in);

} // namespace culm::farm
