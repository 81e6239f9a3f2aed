// SPDX-License-Identifier: BSD-3-Clause
// Computes a range of batches and says what became of it.
#pragma once

#include "farm/batch.hpp"
#include "farm/map_call.hpp"
#include "farm/scheduler.hpp"
#include "farm/start_permit.hpp"
#include "farm/summary.hpp"
#include "farm/wire.hpp"

#include <cstdint>
#include <string>
#include <vector>

namespace culm::farm {

struct RangeOutcome {
    Range range;
    std::int64_t executed = 0; ///< batches begun; fewer than the range has after a stop, or when
                               ///< the next would not have been done by the deadline
    double seconds = 0.0;      ///< wall time of the range
    BatchReport tally;         ///< sums over the batches that returned
    std::vector<LostBatch> lost;
    std::string failure; ///< text of a core::StorageError
};

/// Calls the work function for each batch until the end, a stop, a core::StorageError or a batch
/// that has no permit to begin. All other exceptions but FarmError (communication itself is broken)
/// are data.
[[nodiscard]] RangeOutcome run_range(const MapCall& call, Range range, Heartbeat& heartbeat,
                                     const StartPermit& permit);

void put(WireWriter& out, const RangeOutcome& outcome);
[[nodiscard]] RangeOutcome get_range_outcome(WireReader& in, int source);

} // namespace culm::farm
