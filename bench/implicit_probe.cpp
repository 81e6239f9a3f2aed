// SPDX-License-Identifier: BSD-3-Clause
#include "bench/implicit_probe.hpp"

#include "bench/cpu_time.hpp"
#include "core/error.hpp"
#include "integrate/history_sampler.hpp"
#include "integrate/statics.hpp"
#include "integrate/sundials/integrator.hpp"
#include "reduce/ring_down/ring_down_fit.hpp"
#include "tests/support/integrate_implicit.hpp"

#include <algorithm>
#include <cmath>

namespace culm::bench {
namespace {

constexpr std::size_t sample_count = static_cast<std::size_t>(record_length / sample_interval) + 1;

Probe integrate_once(const StartedStem& started, const Method& method,
                     const ProbeOptions& options) {
    const physics::Chain<2, double> chain(started.stem, physics::schramm2019_law());
    const int tip = started.stem.sphere_count - 1;
    Probe probe;
    const double start = cpu_seconds();
    integrate::HistorySampler<2> sampler(
        chain.layout(), tip, tip, sample_interval, sample_count, false,
        [&probe](std::size_t, const auto& rates) { probe.tip.push_back(rates[0][1]); });
    Problem problem{
        chain,
        started.state,
        integrate::cantilever_scales(started.stem, started.deflection),
        options.tolerance,
        [&sampler](double time, std::span<const double> at) { sampler.observe(time, at); },
        [&] { return cpu_seconds() - start < options.cpu_budget; }};
    probe.cost = method(problem);
    sampler.finish();
    probe.cpu_seconds = cpu_seconds() - start;
    return probe;
}

void fit(Probe& probe) {
    std::vector<double> times(probe.tip.size());
    for (std::size_t k = 0; k < times.size(); ++k)
        times[k] = static_cast<double>(k) * sample_interval;
    const reduce::RingDownFit eq1 = reduce::fit_ring_down(times, probe.tip);
    probe.frequency = eq1.frequency.value;
    probe.decay_per_cycle = eq1.decay_per_cycle.value;
}

} // namespace

physics::StemParameters<double> published_stem(double bond_youngs_modulus, double bond_damping) {
    physics::StemParameters<double> stem;
    stem.bond_youngs_modulus = bond_youngs_modulus;
    stem.bond_damping = bond_damping;
    return stem;
}

StartedStem released_stem(double bond_youngs_modulus, double bond_damping) {
    const auto stem = published_stem(bond_youngs_modulus, bond_damping);
    const physics::Chain<2, double> chain(stem, physics::schramm2019_law());
    return {stem, integrate::deflected_equilibrium(chain, released_deflection).state,
            released_deflection};
}

Method method_in_use() {
    return [](Problem& problem) {
        integrate::ImplicitOptions options;
        options.relative_tolerance = problem.tolerance;
        options.heartbeat = problem.heartbeat;
        return integrate::integrate_implicit(problem.chain, problem.state, problem.scales,
                                             record_length, problem.observe, options);
    };
}

namespace {} // namespace

Method arkode_method(const std::string& table) {
    return [table](Problem& problem) {
        integrate::ImplicitOptions options;
        options.relative_tolerance = problem.tolerance;
        options.heartbeat = problem.heartbeat;
        integrate::SundialsIntegrator<2> integrator(problem.chain.layout(), table);
        const integrate::LaneOutcome outcome = integrator.integrate(
            problem.chain, problem.state, problem.scales, record_length, problem.observe, options);
        if (outcome.failure)
            throw *outcome.failure;
        return outcome.work;
    };
}

std::optional<Probe> probe_ring_down(const StartedStem& start, const Method& method,
                                     const ProbeOptions& options) {
    try {
        Probe probe = integrate_once(start, method, options);
        fit(probe);
        for (int k = 1; k < options.repeats && probe.cpu_seconds < 0.25 * options.cpu_budget; ++k)
            probe.cpu_seconds =
                std::min(probe.cpu_seconds, integrate_once(start, method, options).cpu_seconds);
        return probe;
    } catch (const integrate::Interrupted&) {
        return std::nullopt;
    } catch (const core::NumericalError&) {
        return std::nullopt;
    }
}

double tip_error(const Probe& probe, const Probe& reference) {
    double largest = 0.0;
    for (std::size_t k = 0; k < reference.tip.size(); ++k)
        largest = std::max(largest, std::abs(probe.tip[k] - reference.tip[k]));
    return largest / released_deflection;
}

} // namespace culm::bench
