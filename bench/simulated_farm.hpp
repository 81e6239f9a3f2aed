// SPDX-License-Identifier: BSD-3-Clause
// A farm of many ranks as a discrete-event simulation around the real farm::Scheduler.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace culm::bench {

/// Model of the network and of the other ranks' processors.
struct FarmModel {
    int ranks = 1;
    double chunk_seconds = 0.01;   ///< FarmOptions::chunk_seconds
    double seconds_per_cost = 0.0; ///< FarmOptions::seconds_per_cost
    double latency = 50e-6;        ///< s, of a message
    double handling = 5e-6;        ///< s of rank 0's time for a report and its answer
    double beat = 250e-6;          ///< s between two polls for messages by a computing rank
    double longest_sleep = 1e-3;   ///< s, of a rank without work between two polls
};

struct FarmPrediction {
    double makespan = 0.0;          ///< s, until the last rank has left the map
    double efficiency = 0.0;        ///< work over makespan times ranks
    double coordinator_share = 0.0; ///< of rank 0's time that goes into messages
    double largest_delay = 0.0;     ///< s, of an answer
    double longest_batch = 0.0;     ///< s: no schedule ends earlier
    std::int64_t messages = 0;      ///< reports to rank 0
};

/// Simulates a map of batches that take `seconds` and were expected to cost `costs` (both in the
/// order of the plan: costs descend).
[[nodiscard]] FarmPrediction simulate_farm(std::span<const double> costs,
                                           std::span<const double> seconds, const FarmModel& model);

} // namespace culm::bench
