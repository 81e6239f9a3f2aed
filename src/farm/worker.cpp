// SPDX-License-Identifier: BSD-3-Clause
// A rank other than 0 during a map.
#include "farm/mailbox.hpp"
#include "farm/map_call.hpp"

#include <deque>
#include <optional>
#include <string>
#include <utility>

#include <fmt/format.h>

namespace culm::farm {

namespace {

class Worker final : public Heartbeat {
  public:
    Worker(const MapCall& call, Mailbox& mailbox)
        : Heartbeat(call.options.poll_interval), call_(call), mailbox_(mailbox),
          stop_condition_(call.options), permit_(call.options) {
        // The initial ranges need no message: this scheduler deals them as that of rank 0 does.
        const Scheduler scheduler = call.dealt_scheduler();
        const std::span<const Range> hand = scheduler.held_by(call.rank);
        queue_.assign(hand.begin(), hand.end());
    }

    [[nodiscard]] Summary run() {
        // Rank 0 checks that this rank has the same list of batches, even if the list is empty.
        mailbox_.post(0, MessageKind::Started, call_.message());
        Backoff backoff;
        while (!summary_) {
            if (queue_.empty()) {
                poll();
                if (queue_.empty() && !summary_)
                    backoff.pause();
                continue;
            }
            backoff.reset();
            const Range range = queue_.front();
            queue_.pop_front();
            const RangeOutcome outcome = run_range(call_, range, *this, permit_);
            if (!outcome.failure.empty())
                accept_stop();
            mailbox_.post(0, MessageKind::Report, call_.message(outcome));
        }
        mailbox_.post(0, MessageKind::Farewell, call_.message());
        backoff.reset();
        while (!mailbox_.is_flushed())
            backoff.pause();
        return *std::move(summary_);
    }

  private:
    void poll() override {
        receive_messages();
        watch_stop();
        (void)mailbox_.is_flushed();
    }

    void receive_messages() {
        // Nothing is received after the summary, because later messages belong to the next map.
        while (!summary_) {
            std::optional<Message> message = mailbox_.receive();
            if (!message)
                return;
            core::WireReader in(std::move(message->bytes));
            const bool has_same_batches = in.get<std::uint64_t>() == call_.digest;
            // A range of another list means other batches here; rank 0 stops when it detects that.
            if (message->kind == MessageKind::Assign && has_same_batches) {
                queue_.push_back(in.get<Range>());
                permit_.set_pace(in.get<double>());
            } else if (message->kind == MessageKind::Stop)
                accept_stop();
            else if (message->kind == MessageKind::Summary)
                summary_ = in.get<Summary>();
        }
    }

    void watch_stop() {
        if (stop_requested())
            return;
        try {
            if (!stop_condition_.is_met(Clock::now()))
                return;
            mailbox_.post(0, MessageKind::Stop, call_.message(stop_condition_.is_too_late()));
        } catch (const FarmError&) {
            throw;
        } catch (const std::exception& error) {
            const std::string reason = fmt::format("rank {}: {}", call_.rank, error.what());
            mailbox_.post(0, MessageKind::Failure, call_.message(reason));
        }
        accept_stop();
    }

    const MapCall& call_;
    Mailbox& mailbox_;
    StopCondition stop_condition_;
    StartPermit permit_;
    std::deque<Range> queue_;
    std::optional<Summary> summary_; ///< rank 0 has declared the map over
};

} // namespace

Summary work_for_rank_0(const MapCall& call, Mailbox& mailbox) {
    return Worker(call, mailbox).run();
}

} // namespace culm::farm
