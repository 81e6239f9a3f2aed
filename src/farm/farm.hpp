// SPDX-License-Identifier: BSD-3-Clause
// A map over batches, spread over the ranks of a communicator.
#pragma once

#include "farm/batch.hpp"
#include "farm/communicator.hpp"
#include "farm/pace.hpp"
#include "farm/summary.hpp"

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <span>

namespace culm::farm {

class Mailbox;

struct FarmOptions {
    /// Called on every rank, at most every `stop_interval`; may be empty. If one rank returns
    /// true, all ranks stop.
    std::function<bool()> stop_requested;
    std::chrono::milliseconds stop_interval{20};
    /// Walltime limit: from then on the farm behaves as if stop_requested were true. Earlier, it
    /// starts no batch that would not finish by then, as far as the pace is known.
    std::optional<Clock::time_point> deadline;
    /// Times of batches measured by earlier maps with the same cost unit. The reports of this map
    /// are added to it (Summary::pace).
    Pace pace;
    /// The clock of the deadline, for tests; empty: Clock.
    std::function<Clock::time_point()> now;
    [[nodiscard]] Clock::time_point time() const { return now ? now() : Clock::now(); }

    /// Called on rank 0 with each answer (BatchReport::answer) when it arrives; may be empty.
    std::function<void(const BatchAnswer&)> answered;
    /// Called on rank 0 at most every `progress_interval`, and once at the end; may be empty.
    std::function<void(const Progress&)> progress;
    std::chrono::milliseconds progress_interval{1000};

    /// Shortest time between two polls for messages (a poll takes about 1 µs).
    std::chrono::microseconds poll_interval{100};
    /// Batches much shorter than this are handed out several at a time, s; 0: always one by one.
    double chunk_seconds = 0.01;
    /// Expected time of a unit of the batches' cost, s. It is used for the first ranges, before
    /// reports arrive, if `pace` is unknown. 0: unknown.
    double seconds_per_cost = 0.0;
};

/// Every rank computes, rank 0 too: it answers the others between its beats (Heartbeat::beat).
/// While batches run there are only point-to-point messages.
class Farm {
  public:
    /// A farm of one rank, without MPI.
    Farm();

    /// On a duplicate of `communicator`. Collective.
    explicit Farm(const Communicator& communicator);

    ~Farm();
    Farm(const Farm&) = delete;
    Farm& operator=(const Farm&) = delete;

    [[nodiscard]] int rank() const;
    [[nodiscard]] int size() const;

    /// Calls `work` once for every batch, on some rank, longest batches first. Collective: all
    /// ranks pass the same batches and get the same summary, its answers excepted. Only batch
    /// indices travel, so `work` must store its results.
    ///
    /// * If `work` throws, the batch is listed as lost with the exception's text; the farm
    /// continues.
    /// * If it throws core::StorageError or reports a storage failure, or if a function in the
    ///   options throws, all ranks stop and Summary::failure contains the text.
    /// * After a stop no further batch is started. Running batches finish, or end early if `work`
    ///   observes Heartbeat::stop_requested. Summary::stopped_early is true if points are missing.
    /// * A batch that would not finish by the deadline is not started, but shorter ones are. The
    ///   map ends when no batch remains that would finish; Summary::stopped_early is then true.
    /// * The farm does not survive the death of a rank, because no collective call returns after
    ///   it, MPI_Finalize included. Launchers end all ranks then, and the study is resumed.
    ///
    /// Throws FarmError if MPI fails or a cost is invalid.
    [[nodiscard]] Summary map(std::span<const Batch> batches, const Work& work,
                              const FarmOptions& options = {});

  private:
    std::unique_ptr<Mailbox> mailbox_; ///< none with one rank
};

} // namespace culm::farm
