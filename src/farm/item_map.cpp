// SPDX-License-Identifier: BSD-3-Clause
#include "farm/item_map.hpp"

#include "core/error.hpp"

#include <cstddef>
#include <memory>

namespace culm::farm {
namespace {

using Outcomes = std::vector<core::ItemOutcome<core::Bytes>>;

/// A map over ranks with its state between calls.
class RankMap {
  public:
    RankMap(const Communicator* communicator, ItemOptions options)
        : communicator_(communicator), store_(std::move(options.store)),
          farm_(communicator == nullptr ? std::make_shared<Farm>()
                                        : std::make_shared<Farm>(*communicator)) {
        options_.chunk_seconds = 0.0; // an item is never short
        options_.stop_requested = std::move(options.stop_requested);
        options_.deadline = options.deadline;
        options_.progress = std::move(options.progress);
        options_.progress_interval = options.progress_interval;
    }

    Outcomes operator()(const std::vector<double>& costs, const core::ItemMap::EncodedWork& work) {
        Outcomes outcomes(costs.size());
        const std::vector<std::size_t> missing = take_stored(outcomes);
        if (!missing.empty())
            compute(missing, costs, work, outcomes);
        first_number_ += static_cast<std::int64_t>(costs.size());
        return outcomes;
    }

  private:
    [[nodiscard]] std::int64_t number_of(std::size_t item) const {
        return first_number_ + static_cast<std::int64_t>(item);
    }

    /// Fills the outcomes of stored items; returns the others.
    [[nodiscard]] std::vector<std::size_t> take_stored(Outcomes& outcomes) const {
        std::vector<std::optional<core::Bytes>> stored(outcomes.size());
        if (store_)
            stored = on_root(communicator_, [&] {
                for (std::size_t item = 0; item < stored.size(); ++item)
                    stored[item] = store_->find(number_of(item));
                return stored;
            });
        std::vector<std::size_t> missing;
        for (std::size_t item = 0; item < stored.size(); ++item) {
            if (!stored[item])
                missing.push_back(item);
            outcomes[item].value = std::move(stored[item]);
        }
        return missing;
    }

    /// An item is a batch of one point; its value is the batch's answer.
    void compute(const std::vector<std::size_t>& items, const std::vector<double>& costs,
                 const core::ItemMap::EncodedWork& work, Outcomes& outcomes) {
        std::vector<Batch> batches(items.size());
        for (std::size_t k = 0; k < items.size(); ++k)
            batches[k] = {{static_cast<std::int64_t>(items[k])}, costs[items[k]]};
        const auto work_on_batch = [&work](const Batch& batch, Heartbeat& heartbeat) {
            BatchReport report;
            try {
                core::ItemMap::EncodedValue value =
                    work(static_cast<std::size_t>(batch.points.front()), [&heartbeat] {
                        heartbeat.beat();
                        return !heartbeat.stop_requested();
                    });
                ++(value.counts_as_failed ? report.failed : report.completed);
                report.answer = std::move(value.bytes);
            } catch (...) {
                if (!heartbeat.stop_requested())
                    throw;
            }
            return report;
        };
        FarmOptions options = options_;
        if (store_)
            options.answered = [&](const BatchAnswer& answer) {
                store_->add(number_of(items[answer.batch]), answer.bytes);
            };
        const Summary summary = farm_->map(batches, work_on_batch, options);
        if (!summary.failure.empty())
            throw core::StorageError(summary.failure);
        if (summary.stopped_early)
            throw core::MapStopped{};
        for (const LostBatch& lost : summary.lost)
            outcomes[items[lost.batch]] = {std::nullopt, lost.reason};
        for (BatchAnswer& answer : on_root(communicator_, [&] { return summary.answers; }))
            outcomes[items[answer.batch]] = {std::move(answer.bytes), {}};
    }

    const Communicator* communicator_;
    FarmOptions options_;
    std::optional<ItemStore> store_;
    std::shared_ptr<Farm> farm_;
    std::int64_t first_number_ = 0; ///< of the next call's items
};

} // namespace

core::ItemMap over_ranks(const Communicator* communicator, ItemOptions options) {
    const auto map = std::make_shared<RankMap>(communicator, std::move(options));
    return core::ItemMap(
        [map](const std::vector<double>& costs, const core::ItemMap::EncodedWork& work) {
            return (*map)(costs, work);
        });
}

} // namespace culm::farm
