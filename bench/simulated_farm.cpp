// SPDX-License-Identifier: BSD-3-Clause
#include "bench/simulated_farm.hpp"

#include "farm/scheduler.hpp"

#include <algorithm>
#include <deque>
#include <functional>
#include <optional>
#include <queue>
#include <random>
#include <utility>

namespace culm::bench {

namespace {

enum class EventKind { RangeDone, ReportArrives, CoordinatorLooks, AssignmentArrives };

struct Event {
    double time = 0.0;
    EventKind kind = EventKind::RangeDone;
    int rank = 0;
    farm::Range range;

    bool operator>(const Event& other) const { return time > other.time; }
};

struct Report {
    int rank = 0;
    farm::Range range;
    double arrival = 0.0;
};

/// Behaves as farm::Coordinator and farm::Worker; the real scheduler makes the decisions.
class SimulatedFarm {
  public:
    SimulatedFarm(std::span<const double> costs, std::span<const double> seconds,
                  const FarmModel& model)
        : model_(model),
          scheduler_(costs, model.ranks, model.chunk_seconds, model.seconds_per_cost),
          queues_(static_cast<std::size_t>(model.ranks)),
          is_busy_(static_cast<std::size_t>(model.ranks)),
          idle_since_(static_cast<std::size_t>(model.ranks)) {
        seconds_before_.push_back(0.0);
        for (const double s : seconds)
            seconds_before_.push_back(seconds_before_.back() + s);
        prediction_.longest_batch = *std::ranges::max_element(seconds);
    }

    FarmPrediction play() {
        scheduler_.deal();
        for (int rank = 0; rank < model_.ranks; ++rank) {
            const auto hand = scheduler_.held_by(rank);
            queues_[index(rank)].assign(hand.begin(), hand.end());
            begin_next(rank, 0.0);
        }
        double now = 0.0;
        while (!events_.empty()) {
            const Event event = events_.top();
            events_.pop();
            now = event.time;
            handle(event);
        }
        // Then rank 0 sends the summary to each worker and waits for each farewell.
        const double dismissal = 2.0 * (model_.ranks - 1) * model_.handling;
        prediction_.makespan = std::max(now, coordinator_free_) + dismissal +
                               (model_.ranks > 1 ? 2.0 * model_.latency : 0.0);
        prediction_.efficiency =
            seconds_before_.back() / (prediction_.makespan * static_cast<double>(model_.ranks));
        prediction_.coordinator_share =
            static_cast<double>(prediction_.messages) * model_.handling / prediction_.makespan;
        return prediction_;
    }

  private:
    static std::size_t index(int rank) { return static_cast<std::size_t>(rank); }

    [[nodiscard]] double seconds(farm::Range range) const {
        return seconds_before_[static_cast<std::size_t>(range.first + range.count)] -
               seconds_before_[static_cast<std::size_t>(range.first)];
    }

    void begin_next(int rank, double now) {
        auto& queue = queues_[index(rank)];
        is_busy_[index(rank)] = !queue.empty();
        if (queue.empty()) {
            idle_since_[index(rank)] = now;
            return;
        }
        events_.push({now + seconds(queue.front()), EventKind::RangeDone, rank, queue.front()});
        queue.pop_front();
    }

    void handle(const Event& event) {
        switch (event.kind) {
        case EventKind::RangeDone:
            finish(event);
            break;
        case EventKind::ReportArrives:
            inbox_.push_back({event.rank, event.range, event.time});
            expect_look(event.time);
            break;
        case EventKind::CoordinatorLooks:
            answer_reports(event.time);
            break;
        case EventKind::AssignmentArrives:
            queues_[index(event.rank)].push_back(event.range);
            if (!is_busy_[index(event.rank)])
                begin_next(event.rank,
                           event.time + sleep(event.time - idle_since_[index(event.rank)]));
            break;
        }
    }

    void finish(const Event& event) {
        if (event.rank != 0) {
            events_.push(
                {event.time + model_.latency, EventKind::ReportArrives, event.rank, event.range});
            begin_next(event.rank, event.time);
            return;
        }
        // Messages have delayed the range of rank 0 by this time.
        if (interruptions_ > 0.0) {
            events_.push({event.time + std::exchange(interruptions_, 0.0), EventKind::RangeDone, 0,
                          event.range});
            return;
        }
        (void)scheduler_.report(0, event.range, event.range.count, seconds(event.range));
        if (const std::optional<farm::Range> next = scheduler_.hand_out(0))
            queues_[0].push_back(*next);
        begin_next(0, std::max(event.time, coordinator_free_));
    }

    /// A rank without work sleeps for growing times, at most as long as it has been waiting.
    double sleep(double waited) {
        return std::uniform_real_distribution(0.0, std::min(waited, model_.longest_sleep))(random_);
    }

    void expect_look(double now) {
        if (look_is_due_)
            return;
        look_is_due_ = true;
        const double until_beat = is_busy_[0]
                                      ? std::uniform_real_distribution(0.0, model_.beat)(random_)
                                      : sleep(now - idle_since_[0]);
        events_.push(
            {std::max(now, coordinator_free_) + until_beat, EventKind::CoordinatorLooks, 0, {}});
    }

    void answer_reports(double now) {
        constexpr int most_messages = 256; // of one look, as in farm::Coordinator
        look_is_due_ = false;
        double time = std::max(now, coordinator_free_);
        for (int served = 0; served < most_messages && !inbox_.empty(); ++served) {
            const Report report = inbox_.front();
            inbox_.pop_front();
            time += model_.handling;
            ++prediction_.messages;
            prediction_.largest_delay = std::max(prediction_.largest_delay, time - report.arrival);
            (void)scheduler_.report(report.rank, report.range, report.range.count,
                                    seconds(report.range));
            while (const std::optional<farm::Range> next = scheduler_.hand_out(report.rank))
                events_.push(
                    {time + model_.latency, EventKind::AssignmentArrives, report.rank, *next});
        }
        if (is_busy_[0])
            interruptions_ += time - now;
        coordinator_free_ = time;
        if (inbox_.empty())
            return;
        look_is_due_ = true;
        events_.push(
            {time + (is_busy_[0] ? model_.beat : 0.0), EventKind::CoordinatorLooks, 0, {}});
    }

    FarmModel model_;
    farm::Scheduler scheduler_;
    std::vector<double> seconds_before_;          ///< (batches + 1)
    std::vector<std::deque<farm::Range>> queues_; ///< (ranks)
    std::vector<bool> is_busy_;                   ///< (ranks)
    std::vector<double> idle_since_;              ///< (ranks), s
    std::priority_queue<Event, std::vector<Event>, std::greater<>> events_;
    std::deque<Report> inbox_; ///< of rank 0
    bool look_is_due_ = false;
    double coordinator_free_ = 0.0; ///< when rank 0 has answered the messages of its last poll
    double interruptions_ = 0.0;    ///< s, by messages during rank 0's range
    std::mt19937_64 random_{1};
    FarmPrediction prediction_;
};

} // namespace

FarmPrediction simulate_farm(std::span<const double> costs, std::span<const double> seconds,
                             const FarmModel& model) {
    return SimulatedFarm(costs, seconds, model).play();
}

} // namespace culm::bench
