// SPDX-License-Identifier: BSD-3-Clause
// Watches one rank's reasons to stop: the caller's function and the deadline.
#pragma once

#include "farm/farm.hpp"

namespace culm::farm {

class StopCondition {
  public:
    /// `options` must outlive the object.
    explicit StopCondition(const FarmOptions& options) : options_(options) {}

    /// Asks at most every `stop_interval`, in between false. Passes on what the function throws.
    [[nodiscard]] bool is_met(Clock::time_point now);

    /// The deadline has passed.
    [[nodiscard]] bool is_too_late() const {
        return options_.deadline && options_.time() >= *options_.deadline;
    }

  private:
    const FarmOptions& options_;
    Clock::time_point due_ = Clock::time_point::min();
};

} // namespace culm::farm
