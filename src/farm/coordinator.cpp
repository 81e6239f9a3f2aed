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
    Coordinator(const MapCall& call, Mailbox* mailbox, std::vector<bool>& alive)
        : Heartbeat(call.options.poll_interval), call_(call), mailbox_(mailbox), alive_(alive),
          scheduler_(call.dealt_scheduler()), stop_condition_(call.options), permit_(call.options),
          progress_due_(start_ + call.options.progress_interval),
          silence_check_due_(start_ + call.options.silence_until_dead),
          last_seen_(static_cast<std::size_t>(call.size), start_) {
        summary_.ranks = call.size;
        summary_.pace = call.options.pace;
        for (const Batch& batch : call.batches)
            summary_.points_total += static_cast<std::int64_t>(batch.points.size());
    }

    [[nodiscard]] Summary run() {
        for (int worker = 1; worker < call_.size; ++worker)
            if (!alive_[static_cast<std::size_t>(worker)])
                scheduler_.withdraw(worker);
        top_up_all();
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
        std::vector<BatchAnswer> kept;
        if (!call_.options.shares_answers)
            kept.swap(summary.answers);
        dismiss_workers(summary);
        if (!call_.options.shares_answers)
            summary.answers.swap(kept);
        return summary;
    }

  private:
    void poll() override {
        call_back();
        serve_messages();
        if (watches_silence())
            watch_silence();
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
        note_sign_of_life(worker);
        core::WireReader in(std::move(message.bytes));
        const auto head = in.get<MessageHead>();
        // A rank that was given up in an earlier map may still be sending for it.
        if (head.map != call_.number)
            return;
        if (head.digest != call_.digest) {
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
        default: // Alive carries no further data.
            break;
        }
    }

    void settle(int rank, RangeOutcome outcome) {
        // False for a range that was taken from the rank when it fell silent: the rank that has it
        // now will report it.
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
        while (alive_[static_cast<std::size_t>(worker)]) {
            const std::optional<Range> range = hand_out(worker);
            if (!range)
                return;
            post(worker, MessageKind::Assign, call_.message(*range, permit_.pace()));
        }
    }

    void top_up_all() {
        for (int worker = 1; worker < call_.size; ++worker)
            top_up(worker);
    }

    void post(int worker, MessageKind kind, core::Bytes content) {
        try {
            mailbox_->post(worker, kind, std::move(content));
        } catch (const FarmError& error) {
            // A send to a dead rank may fail at once. If the farm survives deaths, the failure is
            // treated as a death.
            if (!watches_silence())
                throw;
            declare_dead(worker, error.what());
        }
    }

    // --- stop and progress

    void stop_all(bool is_too_late = false) {
        if (stop_requested())
            return;
        summary_.out_of_time = is_too_late;
        accept_stop();
        scheduler_.stop();
        for (int worker = 1; worker < call_.size; ++worker)
            if (alive_[static_cast<std::size_t>(worker)])
                post(worker, MessageKind::Stop, call_.message());
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
        progress.ranks = static_cast<int>(std::count(alive_.begin(), alive_.end(), true));
        call_.options.progress(progress);
    }

    // --- silence

    void watch_silence() {
        const Clock::time_point now = Clock::now();
        if (now < silence_check_due_)
            return;
        silence_check_due_ = now + call_.options.silence_until_dead / 4;
        for (int worker = 1; worker < call_.size; ++worker) {
            const auto w = static_cast<std::size_t>(worker);
            if (alive_[w] && now - last_seen_[w] > call_.options.silence_until_dead)
                declare_dead(worker, fmt::format("rank {} fell silent", worker));
        }
    }

    void note_sign_of_life(int worker) {
        const auto w = static_cast<std::size_t>(worker);
        if (watches_silence())
            last_seen_[w] = Clock::now();
        if (alive_[w])
            return;
        // The rank was only slow. It gets work again; other ranks compute its former ranges.
        alive_[w] = true;
        top_up(worker);
        if (stop_requested())
            post(worker, MessageKind::Stop, call_.message());
    }

    void declare_dead(int worker, const std::string& reason) {
        alive_[static_cast<std::size_t>(worker)] = false;
        if (const std::optional<Range> range = scheduler_.write_off(worker))
            for (std::int64_t place = range->first; place < range->first + range->count; ++place)
                lose({call_.batch_index(place), worker, reason, true});
        top_up_all();
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
        for (int rank = 0; rank < call_.size; ++rank)
            if (!alive_[static_cast<std::size_t>(rank)])
                summary_.dead_ranks.push_back(rank);
        return summary_;
    }

    void dismiss_workers(const Summary& summary) {
        // Dead ranks get it too, because one that was only slow must not wait forever.
        for (int worker = 1; worker < call_.size; ++worker)
            post(worker, MessageKind::Summary, call_.message(summary));
        for (int worker = 1; worker < call_.size; ++worker)
            await_farewell(worker);
    }

    void await_farewell(int worker) {
        // Receives from this worker alone: others may have started the next map, whose messages
        // must stay in order.
        const Clock::time_point start = Clock::now();
        Backoff backoff;
        while (alive_[static_cast<std::size_t>(worker)]) {
            const std::optional<Message> message = mailbox_->receive(worker);
            if (message && message->kind == MessageKind::Farewell)
                return;
            if (watches_silence() && Clock::now() - start > call_.options.silence_until_dead)
                alive_[static_cast<std::size_t>(worker)] = false;
            if (!message) {
                (void)mailbox_->is_flushed();
                backoff.pause();
            }
        }
    }

    [[nodiscard]] bool watches_silence() const {
        return call_.options.silence_until_dead.count() > 0;
    }

    const MapCall& call_;
    Mailbox* mailbox_;
    std::vector<bool>& alive_;
    Scheduler scheduler_;
    StopCondition stop_condition_;
    StartPermit permit_;
    Clock::time_point start_ = Clock::now();
    Clock::time_point progress_due_;
    Clock::time_point silence_check_due_;
    std::vector<Clock::time_point> last_seen_; ///< (ranks)
    Summary summary_;                          ///< updated while the map runs
};

} // namespace

Summary coordinate(const MapCall& call, Mailbox* mailbox, std::vector<bool>& alive) {
    return Coordinator(call, mailbox, alive).run();
}

} // namespace culm::farm
