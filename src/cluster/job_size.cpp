// SPDX-License-Identifier: BSD-3-Clause
#include "cluster/job_size.hpp"

#include "cluster/walltime.hpp"
#include "core/error.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <queue>

#include <fmt/core.h>

namespace culm::cluster {
namespace {

/// The reference machine's times may be wrong by this factor on another one; learned ones by less.
constexpr double allowance_for_unknown_machine = 2.0;
constexpr double allowance_for_learned_pace = 1.25;
/// For starting MPI, for reading what is there and for writing the archive, s.
constexpr double start_and_end_s = 120.0;
constexpr double shortest_walltime_s = 300.0;

/// Cost on the rank that is through last when batches go out longest first, as the farm does it.
double makespan(std::vector<double> costs, int ranks) {
    std::ranges::sort(costs, std::greater<>());
    std::priority_queue<double, std::vector<double>, std::greater<>> loads(
        std::greater<>(), std::vector<double>(static_cast<std::size_t>(ranks), 0.0));
    double longest = 0.0;
    for (const double cost : costs) {
        const double load = loads.top() + cost;
        loads.pop();
        loads.push(load);
        longest = std::max(longest, load);
    }
    return longest;
}

/// How often a job of this length has to start. In each but the last a rank ends with a gap into
/// which its next batch does not fit.
std::int64_t expected_jobs(const JobSize& size) {
    const double usable = size.walltime_s - std::min(start_and_end_s, size.walltime_s / 10.0);
    if (size.compute_s <= usable)
        return 1;
    const double without_gap = std::max(size.longest_batch_s, usable - size.longest_batch_s);
    return static_cast<std::int64_t>(std::ceil(size.compute_s / without_gap));
}

double in_whole_minutes(double seconds) {
    return 60.0 * std::ceil(seconds / 60.0);
}

} // namespace

JobSize size_job(const std::vector<farm::Batch>& batches, const farm::Pace& pace,
                 const JobRequest& request) {
    JobSize size;
    size.pace_is_learned = pace.is_known();
    const auto most = std::max<std::int64_t>(1, static_cast<std::int64_t>(batches.size()));
    size.ranks = static_cast<int>(
        std::min<std::int64_t>(most, std::int64_t{request.nodes} * request.ranks_per_node));
    size.nodes = (size.ranks + request.ranks_per_node - 1) / request.ranks_per_node;
    std::vector<double> costs;
    for (const farm::Batch& batch : batches)
        costs.push_back(batch.cost);
    const double seconds_per_cost = pace.is_known() ? pace.mean() : 1.0;
    size.core_seconds = std::accumulate(costs.begin(), costs.end(), 0.0) * seconds_per_cost;
    size.longest_batch_s =
        costs.empty() ? 0.0 : std::ranges::max(costs) * (pace.is_known() ? pace.cautious() : 1.0);
    size.compute_s = std::max(makespan(costs, size.ranks) * seconds_per_cost, size.longest_batch_s);
    const double allowance =
        pace.is_known() ? allowance_for_learned_pace : allowance_for_unknown_machine;
    size.walltime_s = request.walltime_s.value_or(in_whole_minutes(
        std::max(shortest_walltime_s, start_and_end_s + allowance * size.compute_s)));
    if (size.longest_batch_s >= size.walltime_s)
        throw core::InputError(fmt::format(
            "--walltime: {} is too short: the longest points of this study take about {} ({})",
            walltime_text(size.walltime_s), walltime_text(size.longest_batch_s),
            pace.is_known() ? "at the pace of its runs so far" : "on the reference machine"));
    size.jobs = expected_jobs(size);
    return size;
}

} // namespace culm::cluster
