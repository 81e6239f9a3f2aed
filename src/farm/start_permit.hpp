// SPDX-License-Identifier: BSD-3-Clause
// Whether a batch may begin: not if it would hardly be done by the deadline.
#pragma once

#include "farm/farm.hpp"

#include <limits>

namespace culm::farm {

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
