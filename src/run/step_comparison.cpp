// SPDX-License-Identifier: BSD-3-Clause
#include "run/step_comparison.hpp"

#include "run/case_lanes.hpp"
#include "run/step_lanes.hpp"

#include <algorithm>
#include <iterator>
#include <limits>
#include <optional>
#include <utility>

#include <fmt/core.h>

namespace culm::run {
namespace {

/// One lane's run: its step, its progress, and its recorded samples.
struct Run {
    std::int64_t steps_per_sample = 0;
    std::size_t recorded = 0; ///< samples
    std::optional<CaseFailure> failure;
    CaseResult result;

    [[nodiscard]] bool is_done(std::size_t samples) const {
        return failure.has_value() || recorded == samples;
    }
    /// Step at which the next sample is due.
    [[nodiscard]] std::int64_t next_step() const {
        return static_cast<std::int64_t>(recorded) * steps_per_sample;
    }
};

/// Records the run of a lane at its next sample, unless its energy has grown.
void record(Run& run, const CaseSpec& spec, bool has_gained, double tip) {
    if (!has_gained) {
        run.result.tip_deflection.push_back(tip);
        ++run.recorded;
        return;
    }
    run.failure =
        CaseFailure{core::FailureKind::Instability,
                    fmt::format("the motion gained energy by t = {:.6g} s with a step of {:.4g} s",
                                static_cast<double>(run.recorded) * spec.sample_interval,
                                spec.sample_interval / static_cast<double>(run.steps_per_sample))};
}

CaseOutcome outcome_of(Run run) {
    if (run.failure)
        return *std::move(run.failure);
    run.result.work.steps = static_cast<std::int64_t>(run.recorded - 1) * run.steps_per_sample;
    run.result.work.rhs_evaluations = run.result.work.steps + 1;
    return std::move(run.result);
}

/// At most lane_count runs, side by side.
template <int Dim>
std::vector<CaseOutcome> compare(const CaseSpec& spec,
                                 std::span<const std::int64_t> steps_per_sample,
                                 const Heartbeat& heartbeat) {
    const std::size_t samples = spec.sample_count();
    std::vector<Run> runs;
    std::vector<double> steps;
    for (const std::int64_t count : steps_per_sample) {
        runs.emplace_back().steps_per_sample = count;
        runs.back().result.tip_deflection.reserve(samples);
        steps.push_back(spec.sample_interval / static_cast<double>(count));
    }
    StepLanes<Dim> lanes(spec, steps);
    // Time is counted in steps, which all lanes take together; the same step number means a
    // different time in each lane.
    for (std::int64_t now = 0;;) {
        const std::vector<bool> gained = lanes.have_gained(unstable_energy_gain);
        std::int64_t next = std::numeric_limits<std::int64_t>::max(); // at which a lane records
        for (std::size_t lane = 0; lane < runs.size(); ++lane) {
            Run& run = runs[lane];
            if (!run.is_done(samples) && run.next_step() == now)
                record(run, spec, gained[lane], lanes.tip(lane));
            if (!run.is_done(samples))
                next = std::min(next, run.next_step());
        }
        if (next == std::numeric_limits<std::int64_t>::max())
            break;
        while (now < next) {
            const std::int64_t count = std::min(steps_per_beat, next - now);
            lanes.advance(count);
            now += count;
            if (heartbeat && !heartbeat())
                throw Abandoned{};
        }
    }
    std::vector<CaseOutcome> outcomes;
    for (Run& run : runs)
        outcomes.push_back(outcome_of(std::move(run)));
    return outcomes;
}

} // namespace

std::vector<CaseOutcome> simulate_with_steps(const CaseSpec& spec,
                                             std::span<const std::int64_t> steps_per_sample,
                                             const Heartbeat& heartbeat) {
    std::vector<CaseOutcome> outcomes;
    for (std::size_t begin = 0; begin < steps_per_sample.size(); begin += core::lane_count) {
        const auto some = steps_per_sample.subspan(
            begin, std::min(core::lane_count, steps_per_sample.size() - begin));
        std::ranges::move(spec.dimensions == 2 ? compare<2>(spec, some, heartbeat)
                                               : compare<3>(spec, some, heartbeat),
                          std::back_inserter(outcomes));
    }
    return outcomes;
}

} // namespace culm::run
