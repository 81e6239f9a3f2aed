// SPDX-License-Identifier: BSD-3-Clause
#include "cli/work_over_ranks.hpp"

#include "cli/gathered_json.hpp"
#include "farm/farm.hpp"

#include <algorithm>
#include <chrono>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

namespace culm::cli {
namespace {

using nlohmann::json;

/// So often is rank 0 told how many items are done.
constexpr std::chrono::milliseconds telling_interval{200};

std::vector<std::string> answers_of(farm::Farm& farm, const farm::Communicator* communicator,
                                    const farm::FarmOptions& options,
                                    const std::vector<double>& costs, const fit::ItemWork& work) {
    std::vector<farm::Batch> batches(costs.size());
    for (std::size_t item = 0; item < costs.size(); ++item)
        batches[item] = {{static_cast<std::int64_t>(item)}, costs[item]};
    std::vector<json> own(costs.size());
    const auto work_on_batch = [&](const farm::Batch& batch, farm::Heartbeat& heartbeat) {
        const auto item = static_cast<std::size_t>(batch.points.front());
        own[item] = work(item, [&heartbeat] {
            heartbeat.beat();
            return !heartbeat.stop_requested();
        });
        farm::BatchReport done;
        ++done.completed;
        return done;
    };
    const farm::Summary summary = farm.map(batches, work_on_batch, options);
    json all = gathered(own, communicator);
    if (communicator != nullptr)
        all = json::parse(communicator->broadcast(all.dump()));
    for (const farm::LostBatch& lost : summary.lost)
        if (std::ranges::find(summary.dead_ranks, lost.rank) == summary.dead_ranks.end())
            throw std::runtime_error(
                fmt::format("item {} on rank {}: {}", lost.batch, lost.rank, lost.reason));
    std::vector<std::string> answers(costs.size());
    for (std::size_t item = 0; item < answers.size(); ++item)
        if (all[item].is_string())
            answers[item] = all[item];
    return answers;
}

} // namespace

fit::WorkMap work_over_ranks(const farm::Communicator* communicator,
                             std::function<void(const farm::Progress&)> progress) {
    const auto farm = communicator == nullptr ? std::make_shared<farm::Farm>()
                                              : std::make_shared<farm::Farm>(*communicator);
    farm::FarmOptions options;
    options.chunk_seconds = 0.0; // an item is never short
    options.progress = std::move(progress);
    options.progress_interval = telling_interval;
    return
        [farm, communicator, options](const std::vector<double>& costs, const fit::ItemWork& work) {
            return costs.empty() ? std::vector<std::string>{}
                                 : answers_of(*farm, communicator, options, costs, work);
        };
}

} // namespace culm::cli
