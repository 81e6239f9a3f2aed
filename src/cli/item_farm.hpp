// SPDX-License-Identifier: BSD-3-Clause
// A few long, independent items spread over ranks one by one, and the command's common end.
#pragma once

#include "core/error.hpp"
#include "farm/farm.hpp"
#include "farm/on_root.hpp"

#include <cstddef>
#include <functional>
#include <string>
#include <utility>
#include <vector>

namespace culm::cli {

using ItemWork = std::function<farm::BatchReport(std::size_t item, farm::Heartbeat& heartbeat)>;

/// Calls `work` once for each item, on some rank; `costs` are relative efforts. `progress` is
/// called on rank 0 and may be empty. Collective.
[[nodiscard]] inline farm::Summary
map_items(const farm::Communicator* communicator, const std::vector<double>& costs,
          const ItemWork& work, std::function<void(const farm::Progress&)> progress = {}) {
    std::vector<farm::Batch> batches(costs.size());
    for (std::size_t i = 0; i < batches.size(); ++i)
        batches[i] = {{static_cast<std::int64_t>(i)}, costs[i]};
    const auto work_on_batch = [&work](const farm::Batch& batch, farm::Heartbeat& heartbeat) {
        return work(static_cast<std::size_t>(batch.points.front()), heartbeat);
    };
    farm::FarmOptions options;
    options.chunk_seconds = 0.0; // an item is never short
    options.progress = std::move(progress);
    return communicator == nullptr ? farm::Farm().map(batches, work_on_batch, options)
                                   : farm::Farm(*communicator).map(batches, work_on_batch, options);
}

/// Rank 0 reports; its exit code, or its error, is that of every rank. Collective.
[[nodiscard]] inline core::ExitCode report_on_root(const farm::Communicator* communicator,
                                                   const std::function<core::ExitCode()>& report) {
    return static_cast<core::ExitCode>(std::stoi(farm::on_root(
        communicator, [&report] { return std::to_string(static_cast<int>(report())); })));
}

} // namespace culm::cli
