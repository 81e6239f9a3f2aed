// SPDX-License-Identifier: BSD-3-Clause
// Shared by the MPI tests of the farm: lists of batches and counts of computed points.
#pragma once

#include "farm/farm.hpp"

#include <chrono>
#include <cstdint>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace culm::farm {

class FarmTest : public ::testing::Test {
  protected:
    /// How often each point was computed on all ranks together. Collective.
    [[nodiscard]] std::map<std::int64_t, int>
    count_everywhere(const std::vector<std::int64_t>& mine) const {
        std::ostringstream text;
        for (const std::int64_t point : mine)
            text << point << ' ';
        std::string joined;
        for (const std::string& part : world_.gather(text.str()))
            joined += part;
        std::istringstream all(world_.broadcast(joined));
        std::map<std::int64_t, int> counts;
        for (std::int64_t point = 0; all >> point;)
            ++counts[point];
        return counts;
    }

    /// Expects points 0 … count − 1, each computed once.
    static void expect_each_once(const std::map<std::int64_t, int>& counts, std::int64_t count) {
        EXPECT_EQ(counts.size(), static_cast<std::size_t>(count));
        for (const auto& [point, times] : counts)
            EXPECT_EQ(times, 1) << "point " << point;
    }

    /// `count` batches of `size` points each; points are numbered throughout.
    [[nodiscard]] static std::vector<Batch> equal_batches(std::int64_t count, std::int64_t size) {
        std::vector<Batch> batches(static_cast<std::size_t>(count));
        std::int64_t point = 0;
        for (Batch& batch : batches)
            for (std::int64_t i = 0; i < size; ++i)
                batch.points.push_back(point++);
        return batches;
    }

    [[nodiscard]] static BatchReport all_completed(const Batch& batch) {
        return {static_cast<std::int64_t>(batch.points.size()), 0, 0.0};
    }

    /// Works for this time.
    static void spin(double milliseconds, Heartbeat& heartbeat) {
        const auto end = Clock::now() + std::chrono::duration<double, std::milli>(milliseconds);
        while (Clock::now() < end)
            heartbeat.beat();
    }

    /// Expects the same summary on all ranks. Collective.
    void expect_same_everywhere(const Summary& summary) const {
        EXPECT_EQ(core::decoded<Summary>(world_.broadcast(core::encoded(summary))), summary)
            << "on rank " << world_.rank();
    }

    Communicator world_ = Communicator::world();
    Farm farm_{world_};
};

} // namespace culm::farm
