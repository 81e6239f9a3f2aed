// SPDX-License-Identifier: BSD-3-Clause
#include "farm/scheduler.hpp"

#include <algorithm>

namespace culm::farm {

Scheduler::Scheduler(std::span<const double> costs, int ranks, double chunk_seconds,
                     double seconds_per_cost)
    : remaining_(static_cast<std::int64_t>(costs.size())),
      chunk_seconds_(chunk_seconds > 0.0 ? std::max(chunk_seconds, ranks * coordinator_seconds)
                                         : 0.0),
      expected_seconds_per_cost_(seconds_per_cost) {
    held_.resize(static_cast<std::size_t>(ranks));
    cost_before_.reserve(costs.size() + 1);
    cost_before_.push_back(0.0);
    for (const double cost : costs)
        cost_before_.push_back(cost_before_.back() + cost);
}

void Scheduler::deal() {
    const int ranks = static_cast<int>(held_.size());
    for (std::size_t round = 1; round <= 2; ++round)
        for (int rank = 0; rank < ranks && remaining_ > 0; ++rank)
            if (held_by(rank).size() < round)
                (void)hand_out(rank);
}

std::optional<Range> Scheduler::hand_out(int rank, double cost_limit) {
    auto& held = held_[static_cast<std::size_t>(rank)];
    // A worker has its next range when one is done, so it never waits for a message; rank 0 reads
    // the list directly.
    const std::size_t most_held = rank == 0 ? 1 : 2;
    if (stopped_ || remaining_ == 0 || held.size() >= most_held)
        return std::nullopt;
    const bool is_prefetch = !held.empty();
    // A batch that waits behind a busy rank would keep another rank idle at the end.
    if (is_prefetch && remaining_ < static_cast<std::int64_t>(held_.size()))
        return std::nullopt;
    // Returned ranges first: they come earliest in the order, so they are the longest. Withheld
    // batches last: they may run only if the pace is better than expected.
    std::optional<Range> range = take_returned_range(cost_limit);
    if (!range)
        range = take_fresh_range(cost_limit);
    if (!range)
        range = take_withheld_batch(cost_limit);
    if (!range)
        return std::nullopt;
    remaining_ -= range->count;
    ++ranges_held_;
    held.push_back(*range);
    return range;
}

bool Scheduler::report(int rank, Range range, std::int64_t executed, double seconds) {
    auto& held = held_[static_cast<std::size_t>(rank)];
    const auto place = std::find(held.begin(), held.end(), range);
    // A rank that was given up may still report. Its range has been handed out again, and batches
    // must not be counted twice.
    if (place == held.end())
        return false;
    held.erase(place);
    --ranges_held_;
    const Range done{range.first, std::clamp<std::int64_t>(executed, 0, range.count)};
    finished_cost_ += cost_of(done);
    finished_seconds_ += seconds;
    take_back({done.first + done.count, range.count - done.count});
    return true;
}

void Scheduler::withdraw(int rank) {
    auto& held = held_[static_cast<std::size_t>(rank)];
    ranges_held_ -= static_cast<std::int64_t>(held.size());
    for (const Range range : held)
        take_back(range);
    held.clear();
}

std::optional<Range> Scheduler::take_returned_range(double cost_limit) {
    while (!taken_back_.empty()) {
        const Range range = without_too_costly(taken_back_.back(), cost_limit);
        taken_back_.pop_back();
        if (range.count == 0)
            continue;
        const Range part{range.first, length_within(range.first, range.count, cost_limit)};
        if (part.count < range.count)
            taken_back_.push_back({part.first + part.count, range.count - part.count});
        return part;
    }
    return std::nullopt;
}

std::optional<Range> Scheduler::take_fresh_range(double cost_limit) {
    const auto batches = static_cast<std::int64_t>(cost_before_.size()) - 1;
    next_ = without_too_costly({next_, batches - next_}, cost_limit).first;
    if (next_ == batches)
        return std::nullopt;
    const Range range{next_, chunk_length(cost_limit)};
    next_ += range.count;
    return range;
}

std::optional<Range> Scheduler::take_withheld_batch(double cost_limit) {
    // Costs descend along the order: the last batch of a range is the cheapest.
    for (Range& range : withheld_) {
        const Range last{range.first + range.count - 1, 1};
        if (range.count == 0 || cost_of(last) > cost_limit)
            continue;
        --range.count;
        return last;
    }
    return std::nullopt;
}

/// Costs descend along the order: the batches at the front that exceed the limit are withheld.
Range Scheduler::without_too_costly(Range range, double cost_limit) {
    std::int64_t low = 0;
    for (std::int64_t high = range.count; low < high;) {
        const std::int64_t middle = low + (high - low) / 2;
        if (cost_of({range.first + middle, 1}) > cost_limit)
            low = middle + 1;
        else
            high = middle;
    }
    if (low > 0)
        withheld_.push_back({range.first, low});
    return {range.first + low, range.count - low};
}

std::int64_t Scheduler::chunk_length(double cost_limit) const {
    // Guided self-scheduling (scheduler.hpp): both bounds, by number and by cost, apply,
    // because expensive batches at the front do not predict the many cheap ones at the end.
    const auto shares = 2 * static_cast<std::int64_t>(held_.size());
    const auto batches = static_cast<std::int64_t>(cost_before_.size()) - 1;
    const std::int64_t longest = (batches - next_) / shares;
    const bool is_known = finished_cost_ > 0.0;
    if (longest <= 1 || (!is_known && expected_seconds_per_cost_ <= 0.0))
        return 1;
    const double start = cost_before_[static_cast<std::size_t>(next_)];
    const double share = (total_cost() - start) / static_cast<double>(shares);
    const double seconds_per_cost =
        is_known ? finished_seconds_ / finished_cost_ : expected_seconds_per_cost_;
    // Written without a division by the seconds, which are zero for work that costs nothing.
    const double budget =
        share * seconds_per_cost <= chunk_seconds_ ? share : chunk_seconds_ / seconds_per_cost;
    return length_within(next_, longest, std::min(budget, cost_limit));
}

/// Number of batches from `first` on, at least one and at most `longest`, that fit the budget.
std::int64_t Scheduler::length_within(std::int64_t first, std::int64_t longest,
                                      double budget) const {
    const auto before = cost_before_.begin() + first;
    const auto end = std::upper_bound(before + 1, before + longest + 1, *before + budget);
    return std::max<std::int64_t>(1, end - before - 1);
}

double Scheduler::cost_of(Range range) const {
    return cost_before_[static_cast<std::size_t>(range.first + range.count)] -
           cost_before_[static_cast<std::size_t>(range.first)];
}

void Scheduler::take_back(Range range) {
    if (range.count == 0)
        return;
    taken_back_.push_back(range);
    remaining_ += range.count;
}

} // namespace culm::farm
