// SPDX-License-Identifier: BSD-3-Clause
#include "run/step_comparison.hpp"

#include "run/case_lanes.hpp"
#include "run/step_lanes.hpp"

#include <algorithm>
#include <limits>
#include <optional>

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

template <int Dim>
class Comparison {
  public:
    Comparison(const CaseSpec& spec, std::span<const std::int64_t> steps_per_sample)
        : spec_(spec), samples_(spec.sample_count()), lanes_(spec, steps(spec, steps_per_sample)) {
        for (const std::int64_t count : steps_per_sample) {
            runs_.emplace_back().steps_per_sample = count;
            runs_.back().result.tip_deflection.reserve(samples_);
        }
    }

    [[nodiscard]] std::vector<CaseOutcome> run(const Heartbeat& heartbeat) {
        // Time is counted in steps, which all lanes take together; the same step number means a
        // different time in each lane.
        for (std::int64_t now = 0;;) {
            record(now);
            const std::int64_t next = next_event();
            if (next == std::numeric_limits<std::int64_t>::max())
                return outcomes();
            while (now < next) {
                const std::int64_t count = std::min(steps_per_beat, next - now);
                lanes_.advance(count);
                now += count;
                if (heartbeat && !heartbeat())
                    throw Abandoned{};
            }
        }
    }

  private:
    [[nodiscard]] static std::vector<double> steps(const CaseSpec& spec,
                                                   std::span<const std::int64_t> steps_per_sample) {
        std::vector<double> steps;
        for (const std::int64_t count : steps_per_sample)
            steps.push_back(spec.sample_interval / static_cast<double>(count));
        return steps;
    }

    /// Step at which the next lane records; the largest number when all are done.
    [[nodiscard]] std::int64_t next_event() const {
        std::int64_t next = std::numeric_limits<std::int64_t>::max();
        for (const Run& run : runs_)
            if (!run.is_done(samples_))
                next = std::min(next, run.next_step());
        return next;
    }

    /// Records every lane whose sample is due at step `now`, unless its energy has grown.
    void record(std::int64_t now) {
        const std::vector<bool> gained = lanes_.have_gained(unstable_energy_gain);
        for (std::size_t lane = 0; lane < runs_.size(); ++lane) {
            Run& run = runs_[lane];
            if (run.is_done(samples_) || run.next_step() != now)
                continue;
            if (gained[lane]) {
                run.failure = CaseFailure{
                    core::FailureKind::Instability,
                    fmt::format("the motion gained energy by t = {:.6g} s with a step of {:.4g} s",
                                static_cast<double>(run.recorded) * spec_.sample_interval,
                                spec_.sample_interval / static_cast<double>(run.steps_per_sample))};
                continue;
            }
            run.result.tip_deflection.push_back(lanes_.tip(lane));
            ++run.recorded;
        }
    }

    [[nodiscard]] std::vector<CaseOutcome> outcomes() {
        std::vector<CaseOutcome> out;
        for (Run& run : runs_) {
            if (run.failure) {
                out.emplace_back(std::move(*run.failure));
                continue;
            }
            run.result.work.steps = static_cast<std::int64_t>(samples_ - 1) * run.steps_per_sample;
            run.result.work.rhs_evaluations = run.result.work.steps + 1;
            out.emplace_back(std::move(run.result));
        }
        return out;
    }

    const CaseSpec& spec_;
    std::size_t samples_;
    StepLanes<Dim> lanes_;
    std::vector<Run> runs_;
};

} // namespace

std::vector<CaseOutcome> simulate_with_steps(const CaseSpec& spec,
                                             std::span<const std::int64_t> steps_per_sample,
                                             const Heartbeat& heartbeat) {
    std::vector<CaseOutcome> outcomes;
    for (std::size_t begin = 0; begin < steps_per_sample.size(); begin += core::lane_count) {
        const auto some = steps_per_sample.subspan(
            begin, std::min(core::lane_count, steps_per_sample.size() - begin));
        std::vector<CaseOutcome> found = spec.dimensions == 2
                                             ? Comparison<2>(spec, some).run(heartbeat)
                                             : Comparison<3>(spec, some).run(heartbeat);
        for (CaseOutcome& outcome : found)
            outcomes.push_back(std::move(outcome));
    }
    return outcomes;
}

} // namespace culm::run
