// SPDX-License-Identifier: BSD-3-Clause
// Decides which batches each rank gets next: pure logic without MPI, clocks or threads.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

namespace culm::farm {

/// Consecutive positions [first, first + count) in the plan's order.
struct Range {
    std::int64_t first = 0;
    std::int64_t count = 0;
    friend bool operator==(const Range&, const Range&) = default;
};

/// Dynamic scheduling of batches that are already sorted longest first.
///
/// * A rank has at most two ranges: the one it computes and one queued behind it (prefetch).
///   Rank 0 has one, because it reads the list directly.
/// * Prefetch ends when fewer batches remain than ranks, so that the last ones go to idle ranks.
/// * A range is a single batch unless batches are known, from the reports so far or beforehand, to
///   be so short that messages would dominate. Then it takes `chunk_seconds`, but at most the share
///   1/(2 ranks) of the remaining batches, by number and by cost (guided self-scheduling,
///   Polychronopoulos & Kuck 1987), so that ranges shrink towards the end.
/// * With many ranks a range takes at least `coordinator_seconds` times their number: together they
///   must not send more than rank 0 can answer.
///
/// * With a limit of cost, from the time that remains, batches above it are skipped and shorter
///   ones are handed out. The skipped ones are used if the limit rises again.
///
/// The object is deterministic: the same calls give the same answers on every rank.
class Scheduler {
  public:
    /// Shortest mean time between two reports to rank 0, s: about ten times that for one.
    static constexpr double coordinator_seconds = 50e-6;

    /// `costs`: of the batches in the plan's order, any unit, not all zero. `seconds_per_cost`:
    /// expected time of a unit of cost, used until the first reports; 0: unknown, and ranges are
    /// single batches until then. They always are if `chunk_seconds` is 0.
    Scheduler(std::span<const double> costs, int ranks, double chunk_seconds,
              double seconds_per_cost = 0.0);

    /// Deals the initial ranges: one for every rank in turn, then the prefetched ones. Every rank
    /// can compute them, so the farm starts without a message.
    void deal();

    /// The next range for `rank`, if it may have one now. It costs at most `cost_limit`.
    [[nodiscard]] std::optional<Range>
    hand_out(int rank, double cost_limit = std::numeric_limits<double>::infinity());

    /// `rank` has left `range` after `executed` of its batches (all of them, unless stopped) and
    /// `seconds`. The rest is taken back. False, without effect, if the rank does not (or
    /// no longer) have that range.
    [[nodiscard]] bool report(int rank, Range range, std::int64_t executed, double seconds);

    /// Nothing is handed out from now on.
    void stop() { stopped_ = true; }

    /// Takes back all ranges of `rank`, which is known never to have started.
    void withdraw(int rank);

    /// Ranges of `rank`, the one being computed first.
    [[nodiscard]] std::span<const Range> held_by(int rank) const {
        return held_[static_cast<std::size_t>(rank)];
    }

    /// Nothing is being computed and nothing will be handed out.
    [[nodiscard]] bool is_finished() const {
        return ranges_held_ == 0 && (stopped_ || remaining_ == 0);
    }

    /// Nothing is being computed, but something may remain to be handed out.
    [[nodiscard]] bool is_idle() const { return ranges_held_ == 0; }

    [[nodiscard]] std::int64_t remaining() const { return remaining_; } ///< batches not handed out
    [[nodiscard]] double finished_cost() const { return finished_cost_; }
    [[nodiscard]] double total_cost() const { return cost_before_.back(); }
    [[nodiscard]] double cost_of(Range range) const;

  private:
    [[nodiscard]] std::optional<Range> take_returned_range(double cost_limit);
    [[nodiscard]] std::optional<Range> take_fresh_range(double cost_limit);
    [[nodiscard]] std::optional<Range> take_withheld_batch(double cost_limit);
    [[nodiscard]] Range without_too_costly(Range range, double cost_limit);
    [[nodiscard]] std::int64_t chunk_length(double cost_limit) const;
    [[nodiscard]] std::int64_t length_within(std::int64_t first, std::int64_t longest,
                                             double budget) const;
    void take_back(Range range);

    std::vector<double> cost_before_;      ///< (batches + 1): sum of the costs before each position
    std::vector<std::vector<Range>> held_; ///< (ranks), each of at most two ranges
    std::vector<Range> taken_back_;
    std::vector<Range> withheld_; ///< skipped because of the limit
    std::int64_t next_ = 0;       ///< first position never handed out
    std::int64_t remaining_ = 0;
    std::int64_t ranges_held_ = 0;
    double chunk_seconds_;
    double expected_seconds_per_cost_;
    double finished_cost_ = 0.0;
    double finished_seconds_ = 0.0;
    bool stopped_ = false;
};

} // namespace culm::farm
