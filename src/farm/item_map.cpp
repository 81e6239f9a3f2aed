// SPDX-License-Identifier: BSD-3-Clause
#include "farm/item_map.hpp"

#include "core/error.hpp"

#include <memory>

namespace culm::farm {

namespace {

using Outcomes = std::vector<core::ItemOutcome<core::Bytes>>;

/// An item is a batch of one point; its value is the batch's answer.
Outcomes map_over(Farm& farm, const FarmOptions& options, const std::vector<double>& costs,
                  const core::ItemMap::EncodedWork& work) {
    std::vector<Batch> batches(costs.size());
    for (std::size_t item = 0; item < costs.size(); ++item)
        batches[item] = {{static_cast<std::int64_t>(item)}, costs[item]};
    const auto work_on_batch = [&work](const Batch& batch, Heartbeat& heartbeat) {
        core::ItemMap::EncodedValue value =
            work(static_cast<std::size_t>(batch.points.front()), [&heartbeat] {
                heartbeat.beat();
                return !heartbeat.stop_requested();
            });
        BatchReport report;
        ++(value.counts_as_failed ? report.failed : report.completed);
        report.answer = std::move(value.bytes);
        return report;
    };
    Summary summary = farm.map(batches, work_on_batch, options);
    if (!summary.failure.empty())
        throw core::StorageError(summary.failure);
    Outcomes outcomes(costs.size());
    // An item that is neither lost nor answered was not computed before a stop: its outcome is
    // empty.
    for (const LostBatch& lost : summary.lost)
        outcomes[lost.batch] = {std::nullopt, lost.reason, lost.with_rank};
    for (BatchAnswer& answer : summary.answers)
        outcomes[answer.batch] = {std::move(answer.bytes), {}, false};
    return outcomes;
}

} // namespace

core::ItemMap over_ranks(const Communicator* communicator, ItemOptions options) {
    const auto farm =
        communicator == nullptr ? std::make_shared<Farm>() : std::make_shared<Farm>(*communicator);
    FarmOptions farm_options;
    farm_options.chunk_seconds = 0.0; // an item is never short
    farm_options.progress = std::move(options.progress);
    farm_options.progress_interval = options.progress_interval;
    farm_options.silence_until_dead = options.silence_until_dead;
    return core::ItemMap([farm, farm_options](const std::vector<double>& costs,
                                              const core::ItemMap::EncodedWork& work) {
        return costs.empty() ? Outcomes{} : map_over(*farm, farm_options, costs, work);
    });
}

} // namespace culm::farm
