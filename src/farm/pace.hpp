// SPDX-License-Identifier: BSD-3-Clause
// The time of a unit of the batches' cost, estimated from computed batches.
#pragma once

#include <algorithm>
#include <cmath>

namespace culm::farm {

/// Sums over everything that was timed; a plain value that travels between ranks and runs.
struct Pace {
    double cost = 0.0;    ///< Σ c: cost of all timed batches, in the batches' unit
    double seconds = 0.0; ///< Σ t
    double squares = 0.0; ///< Σ t²/c: for the scatter

    void learn(double batch_cost, double batch_seconds) {
        if (!(batch_cost > 0.0) || !(batch_seconds >= 0.0))
            return;
        cost += batch_cost;
        seconds += batch_seconds;
        squares += batch_seconds * batch_seconds / batch_cost;
    }

    [[nodiscard]] bool is_known() const { return cost > 0.0; }

    /// Mean seconds for a unit of cost, weighted by cost. Only if known.
    [[nodiscard]] double mean() const { return seconds / cost; }

    /// Seconds for a unit of cost that a batch rarely exceeds: 1.1 times the mean (one batch may
    /// determine it), plus three standard deviations of the timed batches. Only if known.
    [[nodiscard]] double cautious() const {
        const double variance = std::max(0.0, squares / cost - mean() * mean());
        return 1.1 * mean() + 3.0 * std::sqrt(variance);
    }

    /// The same mean and scatter with a weight of at most `most_cost`: times of an earlier run must
    /// not outweigh those of this one, perhaps on another machine.
    [[nodiscard]] Pace with_weight_up_to(double most_cost) const {
        if (cost <= most_cost)
            return *this;
        const double share = most_cost / cost;
        return {most_cost, seconds * share, squares * share};
    }

    friend bool operator==(const Pace&, const Pace&) = default;
};

} // namespace culm::farm
