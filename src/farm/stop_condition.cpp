// SPDX-License-Identifier: BSD-3-Clause
#include "farm/stop_condition.hpp"

namespace culm::farm {

bool StopCondition::is_met(Clock::time_point now) {
    if (now < due_)
        return false;
    due_ = now + options_.stop_interval;
    if (is_too_late())
        return true;
    return options_.stop_requested && options_.stop_requested();
}

} // namespace culm::farm
