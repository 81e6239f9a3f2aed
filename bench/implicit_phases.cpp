// SPDX-License-Identifier: BSD-3-Clause
// Where the time of an implicit run goes: its kernels timed alone, times how often the run calls
// them.
#include "bench/cpu_time.hpp"
#include "bench/implicit_probe.hpp"
#include "bench/run_program.hpp"
#include "core/error.hpp"
#include "integrate/condensed_newton.hpp"
#include "integrate/history_sampler.hpp"

#include <array>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include <fmt/core.h>

namespace culm::bench {
namespace {

constexpr int repeats = 9;
constexpr int calls_per_repeat = 500;

/// Seconds of one call: the least of the repeats, because the runs' own time is a least one too.
template <class Kernel>
double time_of_call(Kernel&& kernel) {
    return time_repeats(repeats,
                        [&] {
                            for (int k = 0; k < calls_per_repeat; ++k)
                                kernel();
                        })
               .least() /
           calls_per_repeat;
}

/// Seconds of one call of each kernel on a planar chain.
struct KernelTimes {
    double rate;      ///< d(state)/dt
    double jacobian;  ///< every bond's, by dual numbers
    double factorise; ///< condensation and block-tridiagonal LU
    double solve;     ///< right-hand side, substitution, recovery of what was condensed
    double sampler;   ///< one step's node, interpolation included
};

KernelTimes time_kernels(const ReleasedStem& released, double gamma) {
    const physics::Chain<2, double> chain(released.stem, physics::schramm2019_law());
    integrate::CondensedNewton<2> newton(chain);
    std::vector<double> rate(released.state.size());
    std::vector<double> solution(released.state.size());
    KernelTimes times{};
    times.rate = time_of_call([&] { chain.evaluate_rate(released.state.data(), rate.data()); });
    times.jacobian = time_of_call([&] { newton.set_state(released.state.data()); });
    bool is_regular = true;
    times.factorise = time_of_call([&] { is_regular = newton.factorise(gamma) && is_regular; });
    if (!is_regular)
        throw core::NumericalError(core::FailureKind::SolverFailed,
                                   "the Newton matrix is singular");
    times.solve = time_of_call([&] { newton.solve(rate.data(), solution.data()); });

    const int tip = released.stem.sphere_count - 1;
    double last = 0.0;
    integrate::HistorySampler<2> sampler(
        chain.layout(), tip, tip, sample_interval, SIZE_MAX,
        [&last](std::size_t, std::span<const double> at) { last = at[1]; });
    double time = 0.0;
    times.sampler = time_of_call([&] { sampler.observe(time += sample_interval, released.state); });
    return times;
}

void print_row(std::string_view name, std::int64_t calls, double seconds_per_call, double total) {
    const double share = static_cast<double>(calls) * seconds_per_call / total;
    fmt::print("| {:<31} | {:>7} | {:>7.2f} | {:>5.1f} % |\n", name, calls, 1e6 * seconds_per_call,
               100.0 * share);
}

void print_phases(double youngs_modulus, double damping) {
    const ReleasedStem released(youngs_modulus, damping);
    const std::optional<Probe> probe =
        probe_ring_down(released, {.cpu_budget = 20.0, .repeats = 5});
    if (!probe)
        throw core::NumericalError(core::FailureKind::SolverFailed, "the ring-down failed");
    const integrate::SolveSummary& cost = probe->cost;
    // γ is the step times the method's diagonal coefficient.
    const KernelTimes times =
        time_kernels(released, 0.19 * record_length / static_cast<double>(cost.steps));
    const double total = probe->cpu_seconds;
    const double known = static_cast<double>(cost.rhs_evaluations) * times.rate +
                         static_cast<double>(cost.jacobian_evaluations) * times.jacobian +
                         static_cast<double>(cost.factorisations) * times.factorise +
                         static_cast<double>(cost.linear_solves) * times.solve +
                         static_cast<double>(cost.steps) * times.sampler;

    fmt::print("Y = {:.0f} GPa, β = {:.0f}, tolerance 1e-6: {} steps ({} rejected) in {:.1f} ms, "
               "{:.2f} ms per cycle, {:.1f} µs per step\n\n",
               youngs_modulus * 1e-9, damping, cost.steps, cost.rejected_steps, 1e3 * total,
               1e3 * total / probe->cycles(), 1e6 * total / static_cast<double>(cost.steps));
    fmt::print("| what | calls | µs a call | share |\n|---|---:|---:|---:|\n");
    print_row("right-hand side", cost.rhs_evaluations, times.rate, total);
    print_row("Jacobian (dual numbers)", cost.jacobian_evaluations, times.jacobian, total);
    print_row("condensation and factorisation", cost.factorisations, times.factorise, total);
    print_row("solve", cost.linear_solves, times.solve, total);
    print_row("sampling of the tip", cost.steps, times.sampler, total);
    print_row("the rest, per step", cost.steps, (total - known) / static_cast<double>(cost.steps),
              total);
    fmt::print("\n");
}

} // namespace
} // namespace culm::bench

int main() {
    return culm::bench::run_program([] {
        for (const double damping : {1.0, 25.0, 200.0})
            culm::bench::print_phases(1e9, damping);
    });
}
