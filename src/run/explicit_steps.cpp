// SPDX-License-Identifier: BSD-3-Clause
#include "run/explicit_steps.hpp"

#include "integrate/modes.hpp"
#include "integrate/statics.hpp"
#include "integrate/velocity_verlet.hpp"
#include "physics/energy.hpp"
#include "run/case_lanes.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <optional>
#include <utility>

#include <fmt/core.h>

namespace culm::run {
namespace {

/// One stem in every SIMD lane, each lane with its own time step.
///
/// Lanes advance by one common step h₀, so a lane's own step h is obtained by a change of the
/// unit of time: a chain of modulus Y·(h/h₀)² (and gravity g·(h/h₀)²) stepped by h₀ has the same
/// positions as one of modulus Y stepped by h. That is exact, because every damping
/// coefficient 2β√(inertia·stiffness) scales as a stiffness times a time.
template <int Dim>
class StepLanes {
    using Lanes = core::Lanes;

  public:
    /// Releases the case's stem from its deflection with 1 … core::lane_count steps (s); the last
    /// one fills the remaining lanes. Throws core::NumericalError(StaticFailed).
    StepLanes(const CaseSpec& spec, std::span<const double> steps)
        : used_(steps.size()), common_step_(steps.front()),
          steps_([&](auto lane) { return steps[lane < steps.size() ? lane : steps.size() - 1]; }),
          chain_(scaled_stems(spec), spec.law), verlet_(chain_, scaled_states(spec), common_step_),
          straight_(physics::stored_energy(chain_, chain_.straight_state().data())),
          released_(stored_energy()) {}

    StepLanes(const StepLanes&) = delete; // the integrator refers to the chain
    StepLanes& operator=(const StepLanes&) = delete;

    /// `count` steps in every lane.
    void advance(std::int64_t count) { verlet_.advance(count); }

    /// Lateral position of the tip in a lane, m.
    [[nodiscard]] double tip(std::size_t lane) const {
        return verlet_.position(chain_.layout().sphere_count() - 1)[1][lane];
    }

    /// Whether the motion of each lane has gained more than this share of its initial energy, or
    /// its energy is not a number. A released stem only loses energy.
    [[nodiscard]] std::vector<bool> have_gained(double share) const {
        const Lanes energy = stored_energy();
        std::vector<bool> gained(used_);
        for (std::size_t lane = 0; lane < used_; ++lane)
            gained[lane] = !(energy[lane] <= (1.0 + share) * std::abs(released_[lane]));
        return gained;
    }

  private:
    [[nodiscard]] Lanes unit_of_time() const { return steps_ / Lanes(common_step_); }

    [[nodiscard]] physics::StemParameters<Lanes> scaled_stems(const CaseSpec& spec) const {
        const Lanes square = unit_of_time() * unit_of_time();
        physics::StemParameters<Lanes> stems = packed_stems<Lanes>({&spec, 1});
        stems.bond_youngs_modulus *= square;
        stems.axial_acceleration_of_gravity *= square;
        return stems;
    }

    /// The same shape, held at the tip, in every lane; forces and moments scale as the modulus.
    [[nodiscard]] std::vector<Lanes> scaled_states(const CaseSpec& spec) const {
        const physics::Chain<Dim, double> chain(spec.stem, spec.law);
        const std::vector<double> state =
            integrate::deflected_equilibrium(chain, spec.tip_deflection).state;
        const Lanes square = unit_of_time() * unit_of_time();
        const std::size_t first_history = chain_.layout().bond_offset(0);
        std::vector<Lanes> states(state.begin(), state.end());
        for (std::size_t k = first_history; k < states.size(); ++k)
            states[k] *= square;
        return states;
    }

    /// Energy above that of the straight chain at rest, in each lane's own unit of time.
    [[nodiscard]] Lanes stored_energy() const {
        return physics::stored_energy(chain_, verlet_.state().data()) - straight_;
    }

    std::size_t used_;
    double common_step_; ///< h₀, s
    Lanes steps_;        ///< h of each lane, s
    physics::Chain<Dim, Lanes> chain_;
    integrate::VelocityVerlet<Dim, Lanes> verlet_;
    Lanes straight_; ///< energy of the straight chain
    Lanes released_; ///< energy at the release
};

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

/// Steps tried in one round; independent of the lanes, so that every machine tries the same steps.
constexpr std::size_t trials_per_round = 8;
/// First round: steps from the start/8 to 16 times the start.
constexpr double first_ratio = 2.0;
constexpr int widening_rounds = 6;

/// Whether the motion gains energy within the trial, for each step.
template <int Dim>
std::vector<bool> gains_energy(const CaseSpec& spec, std::span<const double> steps,
                               std::int64_t trial_steps, const Heartbeat& heartbeat) {
    StepLanes<Dim> lanes(spec, steps);
    std::vector<bool> unstable(steps.size(), false);
    for (std::int64_t done = 0; done < trial_steps; done += steps_per_beat) {
        lanes.advance(std::min(steps_per_beat, trial_steps - done));
        const std::vector<bool> gained = lanes.have_gained(unstable_energy_gain);
        for (std::size_t k = 0; k < steps.size(); ++k)
            unstable[k] = unstable[k] || gained[k];
        if (heartbeat && !heartbeat())
            throw Abandoned{};
        if (std::ranges::find(unstable, false) == unstable.end())
            break;
    }
    return unstable;
}

/// Runs a round of ascending steps; returns how many are stable before the first unstable one.
std::size_t stable_among(const CaseSpec& spec, std::span<const double> steps,
                         std::int64_t trial_steps, const Heartbeat& heartbeat) {
    for (std::size_t begin = 0; begin < steps.size(); begin += core::lane_count) {
        const auto some = steps.subspan(begin, std::min(core::lane_count, steps.size() - begin));
        const std::vector<bool> unstable =
            spec.dimensions == 2 ? gains_energy<2>(spec, some, trial_steps, heartbeat)
                                 : gains_energy<3>(spec, some, trial_steps, heartbeat);
        const auto first = std::ranges::find(unstable, true);
        if (first != unstable.end())
            return begin + static_cast<std::size_t>(first - unstable.begin());
    }
    return steps.size();
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

StabilityBracket search_stable_step(const CaseSpec& spec, double start,
                                    const StabilitySearchOptions& options,
                                    const Heartbeat& heartbeat) {
    StabilityBracket bracket;
    const auto round = [&](double first, double ratio) {
        std::vector<double> steps;
        for (std::size_t k = 0; k < trials_per_round; ++k)
            steps.push_back(first * std::pow(ratio, static_cast<double>(k)));
        const std::size_t stable = stable_among(spec, steps, options.trial_steps, heartbeat);
        bracket.trials += static_cast<std::int64_t>(steps.size());
        if (stable > 0)
            bracket.stable = steps[stable - 1];
        if (stable < steps.size())
            bracket.unstable = steps[stable];
    };
    double first = start / 8.0;
    const double span = std::pow(first_ratio, static_cast<double>(trials_per_round));
    for (int k = 0; k < widening_rounds && !(bracket.stable > 0.0 && bracket.unstable > 0.0); ++k) {
        round(first, first_ratio);
        first = bracket.unstable > 0.0 ? first / span : first * span;
    }
    if (bracket.stable == 0.0 || bracket.unstable == 0.0)
        throw core::NumericalError(
            core::FailureKind::Instability,
            fmt::format("no limit of the time step was found: {} step tried is {}",
                        bracket.stable == 0.0 ? "even the smallest" : "even the largest",
                        bracket.stable == 0.0 ? "unstable" : "stable"));
    while (bracket.unstable > bracket.stable * (1.0 + options.tolerance)) {
        // Eight steps divide the bracket into nine equal ratios, at the cost of one run of full
        // lanes.
        const double ratio = std::pow(bracket.unstable / bracket.stable,
                                      1.0 / static_cast<double>(trials_per_round + 1));
        round(bracket.stable * ratio, ratio);
    }
    return bracket;
}

double bond_time(const physics::StemParameters<double>& stem) {
    // √(m/K) with the axial stiffness K = Y A/l of a bond: a wave passes one bond in that time.
    const double stiffness = stem.bond_youngs_modulus * stem.section_area() / stem.bond_length;
    return std::sqrt(stem.sphere_mass() / stiffness);
}

double published_timestep_rule(const physics::StemParameters<double>& stem) {
    return 0.95 / (1.1 + 2.9 * stem.bond_damping) * bond_time(stem);
}

TimestepLimits timestep_limits(const CaseSpec& spec) {
    return {integrate::largest_stable_step(integrate::linearise_transverse(spec.stem, spec.law)),
            integrate::largest_stable_step(integrate::linearise_axial(spec.stem, spec.law)),
            published_timestep_rule(spec.stem)};
}

} // namespace culm::run
