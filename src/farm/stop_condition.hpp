// SPDX-License-Identifier: BSD-3-Clause
// A rank's reasons to stop, and to begin no more batches: the caller's function and the deadline.
#pragma once

#include "farm/farm.hpp"

#include <limits>

namespace culm::farm {

/// Watches the caller's function and the deadline.
class StopCondition {
  public:
    /// `options` must outlive the object.
    explicit StopCondition(const FarmOptions& options) : options_(options) {}

    /// Asks at most every `stop_interval`, in between false. Passes on what the function throws.
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

/// Whether a batch may begin: not if it would hardly be done by the deadline.
class StartPermit {
  public:
    /// `options` must outlive the object. What it says of the pace holds until set_pace.
    explicit StartPermit(const FarmOptions& options)
        : options_(options), seconds_per_cost_(options.pace.is_known() ? options.pace.cautious()
                                                                       : options.seconds_per_cost) {
    }

    /// What a unit of cost takes at most, s; 0: unknown.
    void set_pace(double seconds_per_cost) { seconds_per_cost_ = seconds_per_cost; }
    [[nodiscard]] double pace() const { return seconds_per_cost_; }

    /// Of the largest batch that may begin now. Infinite without a deadline, and, until it has
    /// passed, while nothing is known of the pace.
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

} // namespace culm::farm
