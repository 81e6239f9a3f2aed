// SPDX-License-Identifier: BSD-3-Clause
#include "cli/run_deadline.hpp"

#include "cluster/batch_system.hpp"
#include "cluster/walltime.hpp"
#include "farm/communicator.hpp"

#include <algorithm>
#include <chrono>
#include <string>
#include <utility>

#include <fmt/core.h>

namespace culm::cli {
namespace {

std::optional<cluster::TimeLeft> time_left(const std::string& walltime,
                                           farm::Clock::time_point start) {
    if (walltime.empty())
        return cluster::time_left_of_job(cluster::real_batch_system());
    const std::chrono::duration<double> used = farm::Clock::now() - start;
    return cluster::TimeLeft{cluster::parse_walltime("--walltime", walltime) - used.count(),
                             "--walltime"};
}

double reserve(double seconds) {
    return std::clamp(seconds / 50.0, 1.0, 60.0);
}

} // namespace

std::optional<RunDeadline> run_deadline(const std::string& walltime, farm::Clock::time_point start,
                                        const farm::Communicator* communicator) {
    // All ranks must agree.
    using SecondsAndSource = std::pair<double, std::string>;
    const auto answer = farm::on_root(communicator, [&]() -> std::optional<SecondsAndSource> {
        const auto left = time_left(walltime, start);
        return left ? std::optional<SecondsAndSource>({left->seconds, left->source}) : std::nullopt;
    });
    if (!answer)
        return std::nullopt;
    const auto& [left, source] = *answer;
    const double usable = std::max(0.0, left - reserve(left));
    return RunDeadline{farm::Clock::now() + std::chrono::duration_cast<farm::Clock::duration>(
                                                std::chrono::duration<double>(usable)),
                       fmt::format("this run ends within {} ({}); {} of that may be computed",
                                   cluster::walltime_text(std::max(0.0, left)), source,
                                   cluster::walltime_text(usable))};
}

} // namespace culm::cli
