// SPDX-License-Identifier: BSD-3-Clause
// Rank 0 during a map: it keeps the books, answers the workers and computes batches itself.
#pragma once

#include "farm/heartbeat.hpp"
#include "farm/mailbox.hpp"
#include "farm/map_call.hpp"
#include "farm/range_outcome.hpp"
#include "farm/scheduler.hpp"
#include "farm/start_permit.hpp"
#include "farm/stop_condition.hpp"
#include "farm/summary.hpp"

#include <optional>
#include <string>
#include <vector>

namespace culm::farm {

class Coordinator final : public Heartbeat {
  public:
    /// `mailbox` is null if there is only this rank. `alive` (ranks) is kept up to date.
    Coordinator(const MapCall& call, Mailbox* mailbox, std::vector<bool>& alive);

    [[nodiscard]] Summary run();

  private:
    void poll() override;

    void serve_messages();
    void handle(Message message);
    void settle(int rank, const RangeOutcome& outcome);
    void learn_pace(const RangeOutcome& outcome);
    [[nodiscard]] std::optional<Range> hand_out(int rank);
    void lose(std::size_t batch, int rank, const std::string& reason);

    void top_up(int worker);
    void top_up_all();
    void post(int worker, MessageKind kind, WireWriter content);

    void stop_all(bool is_too_late = false);
    void fail(const std::string& reason);
    void call_back();
    void report_progress(Clock::time_point now);

    [[nodiscard]] bool watches_silence() const {
        return call_.options.silence_until_dead.count() > 0;
    }
    void watch_silence();
    void note_sign_of_life(int worker);
    void declare_dead(int worker, const std::string& reason);

    [[nodiscard]] Summary take_summary();
    void dismiss_workers(const Summary& summary);
    void await_farewell(int worker);

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
    Summary summary_;                          ///< the books: kept while the map runs
};

} // namespace culm::farm
