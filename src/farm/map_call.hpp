// SPDX-License-Identifier: BSD-3-Clause
// The parts of Farm::map that rank 0 and the workers share: its arguments, the computation of a
// range of batches, the two roles.
#pragma once

#include "core/wire.hpp"
#include "farm/batch.hpp"
#include "farm/farm.hpp"
#include "farm/scheduler.hpp"
#include "farm/summary.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <vector>

namespace culm::farm {

/// Watches the caller's function and the deadline.
class StopCondition {
  public:
    /// `options` must outlive the object.
    explicit StopCondition(const FarmOptions& options) : options_(options) {}

    /// Calls the function at most every `stop_interval`; else false. Passes on its exceptions.
    [[nodiscard]] bool is_met(Clock::time_point now) {
        if (now < due_)
            return false;
        due_ = now + options_.stop_interval;
        if (is_too_late())
            return true;
        return options_.stop_requested && options_.stop_requested();
    }

    /// The deadline has passed.
    [[nodiscard]] bool is_too_late() const {
        return options_.deadline && options_.time() >= *options_.deadline;
    }

  private:
    const FarmOptions& options_;
    Clock::time_point due_ = Clock::time_point::min();
};

/// Decides whether a batch may begin: not if it would probably not finish by the deadline.
class StartPermit {
  public:
    /// `options` must outlive the object. Its pace is used until set_pace is called.
    explicit StartPermit(const FarmOptions& options)
        : options_(options), seconds_per_cost_(options.pace.is_known() ? options.pace.cautious()
                                                                       : options.seconds_per_cost) {
    }

    /// Longest time of a unit of cost, s; 0: unknown.
    void set_pace(double seconds_per_cost) { seconds_per_cost_ = seconds_per_cost; }
    [[nodiscard]] double pace() const { return seconds_per_cost_; }

    /// Cost of the largest batch that may begin now. Infinite without a deadline, and before the
    /// deadline while the pace is unknown.
    [[nodiscard]] double cost_limit() const {
        if (!options_.deadline)
            return std::numeric_limits<double>::infinity();
        const double left =
            std::chrono::duration<double>(*options_.deadline - options_.time()).count();
        if (left <= 0.0)
            return -1.0;
        return left / seconds_per_cost_; // infinite for an unknown pace
    }

  private:
    const FarmOptions& options_;
    double seconds_per_cost_;
};

class Mailbox;

struct MapCall {
    std::span<const Batch> batches;
    std::vector<std::size_t> order; ///< plan_order(batches)
    const Work& work;
    const FarmOptions& options;
    std::uint64_t digest; ///< of the batches
    int rank;
    int size;
    /// If all costs are zero, all batches count the same.
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

    /// A message of this map; it begins with the digest of the sender's list of batches.
    template <class... Values>
    [[nodiscard]] core::Bytes message(const Values&... values) const {
        core::WireWriter out;
        out(digest, values...);
        return out.take();
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

struct RangeOutcome {
    Range range;
    std::int64_t executed = 0;  ///< batches started; fewer than in the range after a stop, or if
                                ///< the next one would not have finished by the deadline
    double seconds = 0.0;       ///< wall time of the range
    std::int64_t completed = 0; ///< points; sums over the batches that returned, as the next two
    std::int64_t failed = 0;
    double work_seconds = 0.0;
    std::vector<LostBatch> lost;
    std::vector<BatchAnswer> answers;
    std::string failure; ///< text of a core::StorageError
};

/// Calls the work function for each batch until the end, a stop, a core::StorageError or a batch
/// that may not begin. All other exceptions are recorded, except FarmError (communication failed).
[[nodiscard]] RangeOutcome run_range(const MapCall& call, Range range, Heartbeat& heartbeat,
                                     const StartPermit& permit);

/// Rank 0 during the map: keeps the summary, answers workers, computes batches itself. `mailbox`
/// is null if there is only this rank.
[[nodiscard]] Summary coordinate(const MapCall& call, Mailbox* mailbox);

/// Another rank during the map: computes its ranges and reports them.
[[nodiscard]] Summary work_for_rank_0(const MapCall& call, Mailbox& mailbox);

} // namespace culm::farm
