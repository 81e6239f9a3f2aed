// SPDX-License-Identifier: BSD-3-Clause
// Processor time of this process, which other users of the machine disturb least; wall time.
#pragma once

#include <algorithm>
#include <ctime>
#include <vector>

namespace culm::bench {

/// Seconds that this process has computed so far. Time during which another process used the core
/// does not count, but its effect on the caches does.
[[nodiscard]] inline double cpu_seconds() {
    std::timespec now{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// Seconds on a monotonic clock.
[[nodiscard]] inline double wall_seconds() {
    std::timespec now{};
    clock_gettime(CLOCK_MONOTONIC, &now);
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// Seconds of processor time, one per repeat, and their statistics.
struct Timings {
    std::vector<double> seconds;

    [[nodiscard]] double least() const { return *std::min_element(seconds.begin(), seconds.end()); }
    [[nodiscard]] double median() const {
        std::vector<double> sorted = seconds;
        std::sort(sorted.begin(), sorted.end());
        const std::size_t upper = sorted.size() / 2;
        return sorted.size() % 2 == 1 ? sorted[upper] : 0.5 * (sorted[upper - 1] + sorted[upper]);
    }
};

/// Runs `work` once to warm up and then `repeats` times.
template <class Work>
[[nodiscard]] Timings time_repeats(int repeats, Work&& work) {
    work();
    Timings timings;
    for (int k = 0; k < repeats; ++k) {
        const double start = cpu_seconds();
        work();
        timings.seconds.push_back(cpu_seconds() - start);
    }
    return timings;
}

} // namespace culm::bench
