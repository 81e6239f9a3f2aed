// SPDX-License-Identifier: BSD-3-Clause
#include "farm/range_outcome.hpp"

#include "core/error.hpp"

#include <chrono>

namespace culm::farm {

namespace {

void run_batch(const MapCall& call, std::int64_t place, Heartbeat& heartbeat,
               RangeOutcome& outcome) {
    const auto lose = [&](const char* reason) {
        outcome.lost.push_back({call.batch_index(place), call.rank, reason});
    };
    try {
        const BatchReport report = call.work(call.batch_at(place), heartbeat);
        outcome.tally.completed += report.completed;
        outcome.tally.failed += report.failed;
        outcome.tally.seconds += report.seconds;
        if (!report.storage_failure.empty())
            outcome.failure = report.storage_failure;
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

void put(WireWriter& out, const RangeOutcome& outcome) {
    out.put(outcome.range)
        .put(outcome.executed)
        .put(outcome.seconds)
        .put(outcome.tally.completed)
        .put(outcome.tally.failed)
        .put(outcome.tally.seconds)
        .put_text(outcome.failure)
        .put(outcome.lost.size());
    for (const LostBatch& lost : outcome.lost)
        out.put(lost.batch).put_text(lost.reason);
}

RangeOutcome get_range_outcome(WireReader& in, int source) {
    RangeOutcome outcome;
    in.get(outcome.range);
    in.get(outcome.executed);
    in.get(outcome.seconds);
    in.get(outcome.tally.completed);
    in.get(outcome.tally.failed);
    in.get(outcome.tally.seconds);
    in.get_text(outcome.failure);
    const auto count = in.get<std::size_t>();
    for (std::size_t i = 0; i < count; ++i) {
        LostBatch& lost = outcome.lost.emplace_back();
        in.get(lost.batch);
        lost.rank = source;
        in.get_text(lost.reason);
    }
    return outcome;
}

} // namespace culm::farm
