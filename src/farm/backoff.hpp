// SPDX-License-Identifier: BSD-3-Clause
// Polite waiting: more and more rarely, so that other processes on the same core can work.
#pragma once

#include <algorithm>
#include <chrono>
#include <thread>

namespace culm::farm {

class Backoff {
  public:
    void pause() {
        if (yields_ < max_yields) {
            ++yields_;
            std::this_thread::yield();
            return;
        }
        std::this_thread::sleep_for(sleep_);
        sleep_ = std::min(2 * sleep_, max_sleep);
    }

    void reset() { *this = Backoff(); }

  private:
    /// An answer of a rank that is not busy arrives within some 5 µs; a yield takes below 1 µs.
    static constexpr int max_yields = 50;
    static constexpr std::chrono::microseconds min_sleep{20};
    static constexpr std::chrono::microseconds max_sleep{1000};

    int yields_ = 0;
    std::chrono::microseconds sleep_ = min_sleep;
};

} // namespace culm::farm
