// SPDX-License-Identifier: BSD-3-Clause
// A rank other than 0 during a map: computes what it is given and reports.
#pragma once

#include "farm/heartbeat.hpp"
#include "farm/mailbox.hpp"
#include "farm/map_call.hpp"
#include "farm/start_permit.hpp"
#include "farm/stop_condition.hpp"
#include "farm/summary.hpp"

#include <deque>
#include <optional>

namespace culm::farm {

class Worker final : public Heartbeat {
  public:
    Worker(const MapCall& call, Mailbox& mailbox);

    [[nodiscard]] Summary run();

  private:
    void poll() override;
    void receive_messages();
    void watch_stop();
    void send_alive();
    void post(MessageKind kind, WireWriter content);

    const MapCall& call_;
    Mailbox& mailbox_;
    StopCondition stop_condition_;
    StartPermit permit_;
    std::deque<Range> queue_;
    std::optional<Summary> summary_; ///< rank 0 has declared the map over
    Clock::time_point alive_due_ = Clock::now();
};

} // namespace culm::farm
