// SPDX-License-Identifier: BSD-3-Clause
#include "farm/batch.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>
#include <tuple>

#include <fmt/format.h>

namespace culm::farm {

namespace {

std::int64_t first_point(const Batch& batch) {
    return batch.points.empty() ? std::numeric_limits<std::int64_t>::min() : batch.points.front();
}

} // namespace

std::vector<std::size_t> plan_order(std::span<const Batch> batches) {
    for (std::size_t i = 0; i < batches.size(); ++i)
        if (!std::isfinite(batches[i].cost) || batches[i].cost < 0.0)
            throw FarmError(fmt::format("batch {}: cost = {}: must be finite and not negative", i,
                                        batches[i].cost));
    std::vector<std::size_t> order(batches.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
        return std::tuple(-batches[a].cost, first_point(batches[a]), a) <
               std::tuple(-batches[b].cost, first_point(batches[b]), b);
    });
    return order;
}

std::uint64_t digest(std::span<const Batch> batches) {
    // The constants of Fowler, Noll and Vo. Costs enter by their bits, so that ranks that read
    // different studies are detected before they compute different points under one number.
    constexpr std::uint64_t offset_basis = 14695981039346656037ULL;
    constexpr std::uint64_t prime = 1099511628211ULL;
    std::uint64_t hash = offset_basis;
    const auto mix = [&](std::uint64_t word) {
        for (int byte = 0; byte < 8; ++byte, word >>= 8)
            hash = (hash ^ (word & 0xffU)) * prime;
    };
    for (const Batch& batch : batches) {
        mix(batch.points.size());
        mix(std::bit_cast<std::uint64_t>(batch.cost));
        for (const std::int64_t point : batch.points)
            mix(static_cast<std::uint64_t>(point));
    }
    return hash;
}

} // namespace culm::farm
