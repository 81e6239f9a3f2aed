// SPDX-License-Identifier: BSD-3-Clause
#include "run/simulate.hpp"

#include "core/error.hpp"
#include "core/lanes.hpp"
#include "integrate/modes.hpp"
#include "run/case_lanes.hpp"
#include "run/case_model.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

namespace culm::run {

std::size_t lanes_per_batch() {
    return core::lane_count;
}

std::size_t lanes_per_batch(IntegrationMethod method) {
    return method == IntegrationMethod::Sundials ? 1 : lanes_per_batch();
}

bool can_share_lanes(const CaseSpec& a, const CaseSpec& b) {
    if (a.integrator.method == IntegrationMethod::Sundials ||
        a.integrator.method != b.integrator.method || a.law != b.law ||
        a.stem.sphere_count != b.stem.sphere_count || dimensions_of(a) != dimensions_of(b) ||
        !same_kind_of_model(a, b))
        return false;
    // Lanes take their steps together: implicit ones choose them by a common tolerance, explicit
    // ones must have the same step and the same sample times.
    if (a.integrator.method == IntegrationMethod::Implicit)
        return a.integrator.relative_tolerance == b.integrator.relative_tolerance &&
               a.integrator.step_limit == b.integrator.step_limit;
    return a.integrator.timestep == b.integrator.timestep && a.duration == b.duration &&
           a.sample_interval == b.sample_interval;
}

CaseOutcome Simulator::simulate(const CaseSpec& spec, const Heartbeat& heartbeat) {
    try {
        if (spec.integrator.method == IntegrationMethod::Explicit)
            return simulate_explicit_lanes({&spec, 1}, heartbeat).front();
        const bool is_sundials = spec.integrator.method == IntegrationMethod::Sundials;
        return simulate_implicit_lanes<double>({&spec, 1}, heartbeat,
                                               is_sundials ? &integrators_ : nullptr)
            .front();
    } catch (const core::NumericalError& error) {
        return CaseFailure{error.kind(), error.what()};
    }
}

/// Simulates cases that share lanes. If a user's formula has no value in one lane, all lanes end.
/// Each case is then computed alone, also in lanes: a lane's neighbours do not change its bits.
std::vector<CaseOutcome> Simulator::simulate_lanes(std::span<const CaseSpec> batch,
                                                   const Heartbeat& heartbeat) {
    const IntegrationMethod method = batch.front().integrator.method;
    if (method == IntegrationMethod::Sundials)
        return {simulate(batch.front(), heartbeat)};
    try {
        return method == IntegrationMethod::Implicit
                   ? simulate_implicit_lanes<core::Lanes>(batch, heartbeat)
                   : simulate_explicit_lanes(batch, heartbeat);
    } catch (const core::NumericalError& error) {
        if (batch.size() == 1)
            return {CaseFailure{error.kind(), error.what()}};
    }
    std::vector<CaseOutcome> outcomes;
    outcomes.reserve(batch.size());
    for (const CaseSpec& spec : batch)
        outcomes.push_back(std::move(simulate_lanes({&spec, 1}, heartbeat).front()));
    return outcomes;
}

std::vector<CaseOutcome> Simulator::simulate_together(std::span<const CaseSpec> specs,
                                                      const Heartbeat& heartbeat) {
    std::vector<CaseOutcome> outcomes;
    outcomes.reserve(specs.size());
    for (std::size_t begin = 0; begin < specs.size();) {
        std::size_t end = begin + 1;
        while (end < specs.size() && end - begin < lanes_per_batch() &&
               can_share_lanes(specs[begin], specs[end]))
            ++end;
        std::ranges::move(simulate_lanes(specs.subspan(begin, end - begin), heartbeat),
                          std::back_inserter(outcomes));
        begin = end;
    }
    return outcomes;
}

CaseOutcome simulate(const CaseSpec& spec, const Heartbeat& heartbeat) {
    return Simulator().simulate(spec, heartbeat);
}

double largest_stable_timestep(const CaseSpec& spec) {
    const CaseModel model = case_model(spec);
    if (!model.chain.is_plain()) {
        const physics::Chain<2, double> chain(spec.stem.sphere_count, model.chain, spec.law);
        return integrate::largest_stable_step(integrate::linearise(chain, chain.straight_state()));
    }
    return std::min(
        integrate::largest_stable_step(integrate::linearise_transverse(spec.stem, spec.law)),
        integrate::largest_stable_step(integrate::linearise_axial(spec.stem, spec.law)));
}

} // namespace culm::run
