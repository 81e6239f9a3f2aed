// SPDX-License-Identifier: BSD-3-Clause
// The arguments of one Farm::map, as rank 0 and the workers share them.
#pragma once

#include "farm/batch.hpp"
#include "farm/farm.hpp"
#include "farm/scheduler.hpp"
#include "farm/wire.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace culm::farm {

/// Begins every message of a map.
struct MessageHead {
    std::int64_t map;     ///< number of the map among those of the farm
    std::uint64_t digest; ///< of the sender's list of batches
};

struct MapCall {
    std::span<const Batch> batches;
    std::vector<std::size_t> order; ///< plan_order(batches)
    const Work& work;
    const FarmOptions& options;
    std::uint64_t digest; ///< of the batches
    std::int64_t number;  ///< of this map among those of the farm
    int rank;
    int size;
    /// Without any cost to go by, all batches count the same.
    bool is_costless = std::all_of(batches.begin(), batches.end(),
                                   [](const Batch& batch) { return batch.cost == 0.0; });

    [[nodiscard]] std::size_t batch_index(std::int64_t place) const {
        return order[static_cast<std::size_t>(place)];
    }
    [[nodiscard]] const Batch& batch_at(std::int64_t place) const {
        return batches[batch_index(place)];
    }

    [[nodiscard]] double cost_at(std::int64_t place) const {
        return is_costless ? 1.0 : batch_at(place).cost;
    }

    /// A message of this map, to be continued.
    [[nodiscard]] WireWriter new_message() const {
        return WireWriter().put(MessageHead{number, digest});
    }

    /// A scheduler that has dealt the opening hand, the same on every rank.
    [[nodiscard]] Scheduler dealt_scheduler() const {
        std::vector<double> costs;
        costs.reserve(order.size());
        for (std::size_t place = 0; place < order.size(); ++place)
            costs.push_back(cost_at(static_cast<std::int64_t>(place)));
        Scheduler scheduler(costs, size, options.chunk_seconds,
                            options.pace.is_known() ? options.pace.mean()
                                                    : options.seconds_per_cost);
        scheduler.deal();
        return scheduler;
    }
};

} // namespace culm::farm
