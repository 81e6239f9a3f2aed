// SPDX-License-Identifier: BSD-3-Clause
#include "bench/implicit_probe.hpp"

#include "bench/cpu_time.hpp"
#include "core/error.hpp"
#include "integrate/arkode.hpp"
#include "integrate/history_sampler.hpp"
#include "integrate/implicit.hpp"
#include "integrate/statics.hpp"
#include "reduce/ring_down_fit.hpp"

#include <algorithm>
#include <cmath>

namespace culm::bench {
namespace {

constexpr std::size_t sample_count = static_cast<std::size_t>(record_length / sample_interval) + 1;

Probe integrate_once(const ReleasedStem& released, const ProbeOptions& options) {
    const physics::Chain<2, double> chain(released.stem, physics::schramm2019_law());
    std::vector<double> state = released.state;
    const int tip = released.stem.sphere_count - 1;
    Probe probe;
    const double start = cpu_seconds();
    integrate::HistorySampler<2> sampler(chain.layout(), tip, tip, sample_interval, sample_count,
                                         [&probe](std::size_t, std::span<const double> position) {
                                             probe.tip.push_back(position[1]);
                                         });
    const auto scales = integrate::cantilever_scales(released.stem, tip_deflection);
    const auto observe = [&sampler](double time, std::span<const double> at) {
        sampler.observe(time, at);
    };
    const auto heartbeat = [&] { return cpu_seconds() - start < options.cpu_budget; };
    if (options.butcher_table) {
        integrate::ArkodeOptions arkode;
        arkode.relative_tolerance = options.relative_tolerance;
        arkode.butcher_table = options.butcher_table;
        arkode.heartbeat = heartbeat;
        probe.cost =
            integrate::integrate_arkode(chain, state, scales, record_length, observe, arkode);
    } else {
        integrate::ImplicitOptions implicit;
        implicit.relative_tolerance = options.relative_tolerance;
        implicit.heartbeat = heartbeat;
        probe.cost =
            integrate::integrate_implicit(chain, state, scales, record_length, observe, implicit);
    }
    sampler.finish();
    probe.cpu_seconds = cpu_seconds() - start;
    return probe;
}

void fit(Probe& probe) {
    std::vector<double> times(probe.tip.size());
    for (std::size_t k = 0; k < times.size(); ++k)
        times[k] = static_cast<double>(k) * sample_interval;
    const reduce::RingDownFit eq1 = reduce::fit_ring_down(times, probe.tip);
    probe.frequency = eq1.frequency;
    probe.decay_per_cycle = eq1.decay_per_cycle;
}

} // namespace

ReleasedStem::ReleasedStem(double bond_youngs_modulus, double bond_damping) {
    stem.bond_youngs_modulus = bond_youngs_modulus;
    stem.bond_damping = bond_damping;
    const physics::Chain<2, double> chain(stem, physics::schramm2019_law());
    state = integrate::deflected_equilibrium(chain, tip_deflection).state;
}

std::optional<Probe> probe_ring_down(const ReleasedStem& released, const ProbeOptions& options) {
    try {
        Probe probe = integrate_once(released, options);
        fit(probe);
        for (int k = 1; k < options.repeats && probe.cpu_seconds < 0.25 * options.cpu_budget; ++k)
            probe.cpu_seconds =
                std::min(probe.cpu_seconds, integrate_once(released, options).cpu_seconds);
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
    return largest / tip_deflection;
}

} // namespace culm::bench
