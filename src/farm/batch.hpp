// SPDX-License-Identifier: BSD-3-Clause
// The unit of scheduling: points of a design that one rank computes together, and the heartbeat of
// the function that computes them.
#pragma once

#include "core/wire.hpp"

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

namespace culm::farm {

/// An MPI call failed, a message could not be understood, or a precondition of the farm is
/// violated.
class FarmError : public std::runtime_error {
  public:
    using std::runtime_error::runtime_error;
};

/// Monotonic clock of the whole layer.
using Clock = std::chrono::steady_clock;

/// Handed to every work function, which calls beat() about every millisecond of work.
/// A plain Heartbeat communicates with nobody: for work that runs outside a farm.
class Heartbeat {
  public:
    Heartbeat() = default;
    virtual ~Heartbeat() = default;
    Heartbeat(const Heartbeat&) = delete;
    Heartbeat& operator=(const Heartbeat&) = delete;

    /// Lets the farm communicate, at most once per poll interval; in between it reads only
    /// the clock (about 25 ns). Rank 0 answers the requests of all other ranks here, so they wait
    /// no longer than the larger of the poll interval and the time between two beats.
    void beat() {
        if (Clock::now() < due_)
            return;
        poll();
        due_ = Clock::now() + interval_;
    }

    /// True when this rank has learned of a stop requested on any rank. The work function may
    /// finish its batch or return early with what it has completed.
    [[nodiscard]] bool stop_requested() const { return stop_requested_; }

  protected:
    explicit Heartbeat(Clock::duration interval) : interval_(interval) {}
    virtual void poll() {}
    void accept_stop() { stop_requested_ = true; }

  private:
    Clock::duration interval_ = std::chrono::milliseconds(1);
    Clock::time_point due_ = Clock::time_point::min();
    bool stop_requested_ = false;
};

struct Batch {
    std::vector<std::int64_t> points; ///< ids of the points in the study's design
    double cost = 1.0;                ///< expected effort, >= 0, in any unit that all batches share
};

/// Result of the work function. A batch that ended early reports fewer points than it has.
struct BatchReport {
    std::int64_t completed = 0; ///< points with a result
    std::int64_t failed = 0;    ///< points without; the work function has recorded the reason
    double seconds = 0.0;       ///< computing time, s; summed up in the summary
    /// If not empty, the reason why results can no longer be stored. The farm stops as for a
    /// StorageError, but the points counted here have been stored.
    std::string storage_failure = {};
    /// Result of the batch that is sent to rank 0 with the report (Summary::answers). It must be
    /// small.
    std::optional<core::Bytes> answer = {};
};

/// Computes one batch. An exception means that the batch is lost, see Farm::map.
using Work = std::function<BatchReport(const Batch&, Heartbeat&)>;

/// Order in which the batches (their indices) are handed out: longest first (Graham 1969, "Bounds
/// on multiprocessing timing anomalies": at most 4/3 of the optimal time), ties by the first
/// point's id, then by index. Throws FarmError if a cost is negative or not finite.
[[nodiscard]] std::vector<std::size_t> plan_order(std::span<const Batch> batches);

/// 64-bit FNV-1a hash of all points and costs: two ranks with equal hashes have the same list.
[[nodiscard]] std::uint64_t digest(std::span<const Batch> batches);

} // namespace culm::farm
