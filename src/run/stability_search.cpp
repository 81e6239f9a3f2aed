// SPDX-License-Identifier: BSD-3-Clause
#include "run/stability_search.hpp"

#include "integrate/modes.hpp"
#include "run/case_lanes.hpp"
#include "run/step_lanes.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include <fmt/core.h>

namespace culm::run {
namespace {

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

std::optional<integrate::FirstModeStepError> step_error(const CaseSpec& spec) {
    return integrate::FirstModeStepError::of(integrate::linearise_transverse(spec.stem, spec.law));
}

} // namespace culm::run
