// SPDX-License-Identifier: BSD-3-Clause
// The pulse of a work function: gives the farm a moment to communicate and passes on the wish to
// stop.
#pragma once

#include <chrono>

namespace culm::farm {

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

    /// Lets the farm communicate, at most once per poll interval; in between it costs one reading
    /// of the clock (some 25 ns). On rank 0 this is where the requests of all other ranks are
    /// answered: they wait no longer than the larger of the poll interval and the time between two
    /// beats.
    void beat() {
        if (Clock::now() < due_)
            return;
        poll();
        due_ = Clock::now() + interval_;
    }

    /// True as soon as a stop requested on any rank has become known here. The work function may
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

} // namespace culm::farm
