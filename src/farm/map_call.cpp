// SPDX-License-Identifier: BSD-3-Clause
#include "farm/map_call.hpp"

#include "core/error.hpp"
#include "farm/farm.hpp"
#include "farm/mailbox.hpp"

#include <chrono>
#include <utility>

namespace culm::farm {

namespace {

void run_batch(const MapCall& call, std::int64_t place, Heartbeat& heartbeat,
               RangeOutcome& outcome) {
    const auto lose = [&](const char* reason) {
        outcome.lost.push_back({call.batch_index(place), call.rank, reason});
    };
    try {
        BatchReport report = call.work(call.batch_at(place), heartbeat);
        outcome.completed += report.completed;
        outcome.failed += report.failed;
        outcome.work_seconds += report.seconds;
        if (report.answer)
            outcome.answers.push_back({call.batch_index(place), *std::move(report.answer)});
        if (!report.storage_failure.empty())
            outcome.failure = report.storage_failure;
        // Communication has failed, so nothing can be reported. Every other exception concerns this
        // batch alone and is recorded with it.
    } catch (const FarmError&) {
        throw;
    } catch (const core::StorageError& error) {
        lose(error.what());
        outcome.failure = error.what();
    } catch (const std::exception& error) {
        lose(error.what());
    } catch (...) {
        lose("the work function threw something that is not a std::exception");
    }
}

} // namespace

RangeOutcome run_range(const MapCall& call, Range range, Heartbeat& heartbeat,
                       const StartPermit& permit) {
    RangeOutcome outcome;
    outcome.range = range;
    const Clock::time_point start = call.options.time();
    while (outcome.executed < range.count && outcome.failure.empty()) {
        heartbeat.beat();
        if (heartbeat.stop_requested())
            break;
        const std::int64_t place = range.first + outcome.executed;
        if (call.cost_at(place) > permit.cost_limit())
            break;
        run_batch(call, place, heartbeat, outcome);
        ++outcome.executed;
    }
    outcome.seconds = std::chrono::duration<double>(call.options.time() - start).count();
    return outcome;
}

Farm::Farm() = default;

Farm::Farm(const Communicator& communicator)
    : mailbox_(communicator.size() > 1 ? std::make_unique<Mailbox>(communicator) : nullptr) {}

Farm::~Farm() = default;

int Farm::rank() const {
    return mailbox_ ? mailbox_->rank() : 0;
}

int Farm::size() const {
    return mailbox_ ? mailbox_->size() : 1;
}

Summary Farm::map(std::span<const Batch> batches, const Work& work, const FarmOptions& options) {
    const MapCall call{batches, plan_order(batches), work, options, digest(batches), rank(),
                       size()};
    if (rank() == 0)
        return coordinate(call, mailbox_.get());
    return work_for_rank_0(call, *mailbox_);
}

} // namespace culm::farm
