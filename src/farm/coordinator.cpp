// SPDX-License-Identifier: BSD-3-Clause
// Rank 0 during a map.
#include "core/error.hpp"
#include "farm/mailbox.hpp"
#include "farm/map_call.hpp"

#include <algorithm>
#include <chrono>
#include <optional>
#include <string>
#include <utility>

#include <fmt/format.h>

namespace culm::farm {

namespace {

/// Bounds the messages of one poll, so that rank 0 always has time to compute and stop.
constexpr int max_messages_per_poll = 256;

double seconds_since(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
}

class Coordinator final : public Heartbeat {
  public:
    Coordinator(const MapCall& call, Mailbox* mailbox)
        : Heartbeat(call.options.poll_interval), call_(call), mailbox_(mailbox),
          scheduler_(call.dealt_scheduler()), stop_condition_(call.options), permit_(call.options),
          progress_due_(start_ + call.options.progress_interval) {
        summary_.ranks = call.size;
        summary_.pace = call.options.pace;
        for (const Batch& batch : call.batches)
            summary_.points_total += static_cast<std::int64_t>(batch.points.size());
    }

    [[nodiscard]] Summary run() {
        for (int worker = 1; worker < call_.size; ++worker)
            top_up(worker);
        Backoff backoff;
        while (!scheduler_.is_finished()) {
            if (scheduler_.held_by(0).empty() && !hand_out(0)) {
                poll();
                // No rank works, and no remaining batch would finish by the deadline.
                if (scheduler_.is_idle() && !scheduler_.is_finished() && !hand_out(0)) {
                    summary_.out_of_time = true;
                    scheduler_.stop();
                }
                backoff.pause();
                continue;
            }
            // Rank 0 computes as the others do; between beats of its batch it answers them.
            backoff.reset();
            settle(0, run_range(call_, scheduler_.held_by(0).front(), *this, permit_));
        }
        Summary summary = take_summary();
        dismiss_workers(summary);
        return summary;
    }

  private:
    void poll() override {
        call_back();
        serve_messages();
    }

    // --- messages

    void serve_messages() {
        if (mailbox_ == nullptr)
            return;
        for (int served = 0; served < max_messages_per_poll; ++served) {
            std::optional<Message> message = mailbox_->receive();
            if (!message)
                break;
            handle(std::move(*message));
        }
        (void)mailbox_->is_flushed();
    }

    void handle(Message message) {
        const int worker = message.source;
        core::WireReader in(std::move(message.bytes));
        if (in.get<std::uint64_t>() != call_.digest) {
            fail(fmt::format("rank {} holds another list of batches than rank 0", worker));
            scheduler_.withdraw(worker);
            return;
        }
        switch (message.kind) {
        case MessageKind::Report:
            settle(worker, in.get<RangeOutcome>());
            top_up(worker);
            break;
        case MessageKind::Failure:
            fail(in.get<std::string>());
            break;
        case MessageKind::Stop:
            stop_all(in.get<bool>());
            break;
        default: // Started carries no further data.
            break;
        }
    }

    void settle(int rank, RangeOutcome outcome) {
        // False for a range that was taken from the rank because its list differs.
        if (scheduler_.report(rank, outcome.range, outcome.executed, outcome.seconds)) {
            summary_.points_completed += outcome.completed;
            summary_.points_failed += outcome.failed;
            summary_.work_s += outcome.work_seconds;
            learn_pace(outcome);
            std::ranges::for_each(outcome.lost, [this](LostBatch& lost) { lose(std::move(lost)); });
            for (BatchAnswer& answer : outcome.answers)
                accept(std::move(answer));
        }
        if (!outcome.failure.empty())
            fail(fmt::format("rank {}: {}", rank, outcome.failure));
    }

    void accept(BatchAnswer answer) {
        try {
            if (call_.options.answered)
                call_.options.answered(answer);
        } catch (const core::StorageError& error) {
            fail(error.what());
        }
        summary_.answers.push_back(std::move(answer));
    }

    /// Uses only ranges whose batches were all computed completely.
    void learn_pace(const RangeOutcome& outcome) {
        std::int64_t points = 0;
        const std::int64_t end = outcome.range.first + outcome.executed;
        for (std::int64_t place = outcome.range.first; place < end; ++place)
            points += static_cast<std::int64_t>(call_.batch_at(place).points.size());
        if (outcome.completed + outcome.failed < points)
            return;
        summary_.pace.learn(scheduler_.cost_of({outcome.range.first, outcome.executed}),
                            outcome.seconds);
        if (summary_.pace.is_known())
            permit_.set_pace(summary_.pace.cautious());
    }

    [[nodiscard]] std::optional<Range> hand_out(int rank) {
        return scheduler_.hand_out(rank, permit_.cost_limit());
    }

    void lose(LostBatch lost) {
        summary_.points_lost += static_cast<std::int64_t>(call_.batches[lost.batch].points.size());
        summary_.lost.push_back(std::move(lost));
    }

    void top_up(int worker) {
        while (const std::optional<Range> range = hand_out(worker))
            mailbox_->post(worker, MessageKind::Assign, call_.message(*range, permit_.pace()));
    }

    // --- stop and progress

    void stop_all(bool is_too_late = false) {
        if (stop_requested())
            return;
        summary_.out_of_time = is_too_late;
        accept_stop();
        scheduler_.stop();
        for (int worker = 1; worker < call_.size; ++worker)
            mailbox_->post(worker, MessageKind::Stop, call_.message());
    }

    void fail(const std::string& reason) {
        if (summary_.failure.empty())
            summary_.failure = reason;
        stop_all();
    }

    void call_back() {
        const Clock::time_point now = Clock::now();
        try {
            if (!stop_requested() && stop_condition_.is_met(now))
                stop_all(stop_condition_.is_too_late());
            if (now >= progress_due_)
                report_progress(now);
        } catch (const FarmError&) {
            throw;
        } catch (const std::exception& error) {
            fail(fmt::format("rank 0: {}", error.what()));
        }
    }

    void report_progress(Clock::time_point now) {
        progress_due_ = now + call_.options.progress_interval;
        if (!call_.options.progress)
            return;
        Progress progress;
        progress.points_done = summary_.points_completed + summary_.points_failed;
        progress.points_total = summary_.points_total;
        progress.failed = summary_.points_failed;
        progress.elapsed_s = seconds_since(start_);
        if (const double done = scheduler_.finished_cost(); done > 0.0)
            progress.estimated_remaining_s =
                progress.elapsed_s * std::max(0.0, scheduler_.total_cost() - done) / done;
        progress.ranks = call_.size;
        call_.options.progress(progress);
    }

    // --- the end

    [[nodiscard]] Summary take_summary() {
        try {
            report_progress(Clock::now());
        } catch (const std::exception& error) {
            fail(fmt::format("rank 0: {}", error.what()));
        }
        const std::int64_t settled =
            summary_.points_completed + summary_.points_failed + summary_.points_lost;
        summary_.stopped_early =
            (stop_requested() || summary_.out_of_time) && settled < summary_.points_total;
        summary_.out_of_time = summary_.out_of_time && summary_.stopped_early;
        summary_.elapsed_s = seconds_since(start_);
        // The order of arrival depends on timing; the summary must not depend on it.
        std::ranges::sort(summary_.lost, {}, &LostBatch::batch);
        std::ranges::sort(summary_.answers, {}, &BatchAnswer::batch);
        return summary_;
    }

    void dismiss_workers(const Summary& summary) {
        for (int worker = 1; worker < call_.size; ++worker)
            mailbox_->post(worker, MessageKind::Summary, call_.message(summary));
        for (int worker = 1; worker < call_.size; ++worker)
            await_farewell(worker);
    }

    void await_farewell(int worker) {
        // Receives from this worker alone: others may have started the next map, whose messages
        // must stay in order.
        Backoff backoff;
        while (true) {
            const std::optional<Message> message = mailbox_->receive(worker);
            if (message && message->kind == MessageKind::Farewell)
                return;
            if (!message) {
                (void)mailbox_->is_flushed();
                backoff.pause();
            }
        }
    }

    const MapCall& call_;
    Mailbox* mailbox_;
    Scheduler scheduler_;
    StopCondition stop_condition_;
    StartPermit permit_;
    Clock::time_point start_ = Clock::now();
    Clock::time_point progress_due_;
    Summary summary_; ///< updated while the map runs
};

} // namespace

Summary coordinate(const MapCall& call, Mailbox* mailbox) {
    return Coordinator(call, mailbox).run();
}

} // namespace culm::farm
