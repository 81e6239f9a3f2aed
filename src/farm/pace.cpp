// SPDX-License-Identifier: BSD-3-Clause
#include "farm/pace.hpp"

#include <algorithm>
#include <cmath>

namespace culm::farm {

void Pace::learn(double batch_cost, double batch_seconds) {
    if (!(batch_cost > 0.0) || !(batch_seconds >= 0.0))
        return;
    cost += batch_cost;
    seconds += batch_seconds;
    squares += batch_seconds * batch_seconds / batch_cost;
}

double Pace::cautious() const {
    const double variance = std::max(0.0, squares / cost - mean() * mean());
    return 1.1 * mean() + 3.0 * std::sqrt(variance);
}

Pace Pace::with_weight_up_to(double most_cost) const {
    if (cost <= most_cost)
        return *this;
    const double share = most_cost / cost;
    return {most_cost, seconds * share, squares * share};
}

} // namespace culm::farm
