// SPDX-License-Identifier: BSD-3-Clause
#include "run/simulate.hpp"

#include "integrate/history_sampler.hpp"
#include "integrate/implicit.hpp"
#include "integrate/linearised.hpp"
#include "integrate/statics.hpp"
#include "run/explicit_lanes.hpp"
#include "run/recorder.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

#include <fmt/core.h>

namespace culm::run {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
}

void require_finite(const std::vector<double>& history, double sample_interval) {
    for (std::size_t k = 0; k < history.size(); ++k)
        if (!std::isfinite(history[k]))
            throw core::NumericalError(
                core::FailureKind::NotANumber,
                fmt::format("the tip's position is not a number at t = {:.6g} s",
                            static_cast<double>(k) * sample_interval));
}

template <int Dim>
CaseResult simulate_implicitly(const CaseSpec& spec, const Heartbeat& heartbeat) {
    const auto start = Clock::now();
    const physics::Chain<Dim, double> chain(spec.stem, spec.law);
    std::vector<double> state = integrate::deflected_equilibrium(chain, spec.tip_deflection).state;

    Recorder recorder(spec);
    integrate::HistorySampler<Dim> sampler(
        chain.layout(), recorder.first_watched_sphere(), spec.stem.sphere_count - 1,
        spec.sample_interval, spec.sample_count(),
        [&recorder](std::size_t index, std::span<const double> positions) {
            recorder.record(index, positions);
        });
    integrate::ImplicitOptions options;
    options.relative_tolerance = spec.integrator.relative_tolerance;
    options.heartbeat = heartbeat;
    const integrate::SolveSummary summary = integrate::integrate_implicit(
        chain, state, integrate::cantilever_scales(spec.stem, spec.tip_deflection), spec.duration,
        [&sampler](double time, std::span<const double> at) { sampler.observe(time, at); },
        options);
    sampler.finish();
    require_finite(recorder.result().tip_deflection, spec.sample_interval);

    recorder.result().work = summary;
    recorder.result().wall_seconds = seconds_since(start);
    return std::move(recorder.result());
}

CaseOutcome simulate_implicit_case(const CaseSpec& spec, const Heartbeat& heartbeat) {
    try {
        return spec.dimensions == 2 ? simulate_implicitly<2>(spec, heartbeat)
                                    : simulate_implicitly<3>(spec, heartbeat);
    } catch (const core::NumericalError& error) {
        return CaseFailure{error.kind(), error.what()};
    } catch (const integrate::Interrupted&) {
        throw Abandoned{};
    }
}

} // namespace

CaseOutcome simulate(const CaseSpec& spec, const Heartbeat& heartbeat) {
    return simulate_together({&spec, 1}, heartbeat).front();
}

std::vector<CaseOutcome> simulate_together(std::span<const CaseSpec> specs,
                                           const Heartbeat& heartbeat) {
    std::vector<CaseOutcome> outcomes;
    outcomes.reserve(specs.size());
    for (std::size_t begin = 0; begin < specs.size();) {
        if (specs[begin].integrator.method == IntegrationMethod::Implicit) {
            outcomes.push_back(simulate_implicit_case(specs[begin++], heartbeat));
            continue;
        }
        std::size_t end = begin + 1;
        while (end < specs.size() && end - begin < lanes_per_batch() &&
               can_share_lanes(specs[begin], specs[end]))
            ++end;
        for (CaseOutcome& outcome :
             simulate_explicit_lanes(specs.subspan(begin, end - begin), heartbeat))
            outcomes.push_back(std::move(outcome));
        begin = end;
    }
    return outcomes;
}

double largest_stable_timestep(const CaseSpec& spec) {
    return std::min(
        integrate::largest_stable_step(integrate::linearise_transverse(spec.stem, spec.law)),
        integrate::largest_stable_step(integrate::linearise_axial(spec.stem, spec.law)));
}

} // namespace culm::run
