// SPDX-License-Identifier: BSD-3-Clause
// The cost of cases compared with the estimates of src/study/plan.cpp, and data for its constants.
#include "bench/cpu_time.hpp"
#include "bench/run_program.hpp"
#include "core/error.hpp"
#include "integrate/modes.hpp"
#include "run/simulate.hpp"
#include "study/execute/plan.hpp"

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include <fmt/core.h>

namespace culm::bench {
namespace {

constexpr int repeats = 3;

/// Time of one of several cases that run together.
struct Measured {
    std::int64_t steps = 0;
    double seconds = 0.0; ///< processor time of a case, least of the repeats
};

Measured measure(const std::vector<run::CaseSpec>& specs) {
    Measured measured;
    const Timings timings = time_repeats(repeats, [&] {
        for (const run::CaseOutcome& outcome : run::Simulator().simulate_together(specs)) {
            if (const auto* failure = std::get_if<run::CaseFailure>(&outcome))
                throw core::NumericalError(failure->kind, failure->reason);
            measured.steps = std::get<run::CaseResult>(outcome).work.steps;
        }
    });
    measured.seconds = timings.least() / static_cast<double>(specs.size());
    return measured;
}

run::CaseSpec implicit_case(double youngs_modulus, double damping) {
    run::CaseSpec spec;
    spec.stem.bond_youngs_modulus = youngs_modulus;
    spec.stem.bond_damping = damping;
    return spec;
}

void print_implicit_row(const run::CaseSpec& spec) {
    const Measured measured = measure(std::vector<run::CaseSpec>(run::lanes_per_batch(), spec));
    const double frequency =
        integrate::vibration_modes(integrate::linearise_transverse(spec.stem, spec.law), 1)
            .at(0)
            .frequency;
    const double cycles = frequency * spec.duration;
    const auto steps = static_cast<double>(measured.steps);
    const double bonds = spec.stem.sphere_count - 1;
    const double expected = study::estimated_seconds(spec);
    fmt::print("| {} | {:>4.1f} | {:>3.0f} | {:>3} | {:.0e} | {:>6.1f} | {:>5.2f} | {:>6.2f} | "
               "{:>7.1f} | {:>7.1f} | {:>4.2f} |\n",
               spec.dimensions, spec.stem.bond_youngs_modulus * 1e-9, spec.stem.bond_damping,
               spec.stem.sphere_count, spec.integrator.relative_tolerance, steps / cycles,
               1e6 * measured.seconds / (steps * bonds), 1e3 * measured.seconds / cycles,
               1e3 * measured.seconds, 1e3 * expected, measured.seconds / expected);
    std::fflush(stdout);
}

void print_implicit() {
    fmt::print("Implicit, {:.1f} s of vibration, all lanes filled with equal stems; per stem; "
               "static start "
               "and sampling are included.\n\n"
               "| dim | Y/GPa | β | spheres | tol | steps/cycle | µs per bond and step | ms/cycle "
               "| ms | planned ms | ratio |\n"
               "|---|---:|---:|---:|---|---:|---:|---:|---:|---:|---:|\n",
               run::CaseSpec{}.duration);
    for (const double youngs_modulus : {0.4e9, 1e9, 10e9})
        for (const double damping : {1.0, 2.0, 5.0, 10.0, 25.0, 50.0, 100.0, 200.0})
            print_implicit_row(implicit_case(youngs_modulus, damping));
    for (const double tolerance : {1e-4, 1e-5, 1e-7, 1e-8}) {
        run::CaseSpec spec = implicit_case(1e9, 25.0);
        spec.integrator.relative_tolerance = tolerance;
        print_implicit_row(spec);
    }
    for (const double damping : {1.0, 25.0, 200.0}) {
        run::CaseSpec spec = implicit_case(1e9, damping);
        spec.dimensions = 3;
        print_implicit_row(spec);
    }
    for (const int spheres : {15, 112}) {
        run::CaseSpec spec = implicit_case(1e9, 25.0);
        spec.stem.sphere_count = spheres;
        spec.stem.bond_length = spec.stem.bond_length * 55.0 / (spheres - 1);
        print_implicit_row(spec);
    }
}

void print_explicit_row(int dimensions, std::size_t lanes) {
    run::CaseSpec spec = implicit_case(1e9, 25.0);
    spec.dimensions = dimensions;
    spec.integrator.method = run::IntegrationMethod::Explicit;
    spec.integrator.timestep = 1e-10;
    spec.duration = 1e-4; // long enough to make the cost of the static start negligible
    spec.sample_interval = 1e-6;
    const Measured measured = measure(std::vector<run::CaseSpec>(lanes, spec));
    const double bond_steps = static_cast<double>(measured.steps) * (spec.stem.sphere_count - 1);
    const double expected = study::estimated_seconds(spec);
    fmt::print("| {} | {} | {:>6.2f} | {:>6.2f} | {:>6.2f} |\n", dimensions, lanes,
               1e9 * measured.seconds * static_cast<double>(lanes) / bond_steps,
               1e9 * measured.seconds / bond_steps, measured.seconds / expected);
}

void print_explicit() {
    fmt::print("\nExplicit, through run::simulate_together.\n\n"
               "| dim | stems in lanes | ns per bond and step, all lanes | per stem | measured / "
               "planned |\n|---|---:|---:|---:|---:|\n");
    for (const int dimensions : {2, 3})
        for (const std::size_t lanes : {std::size_t{1}, run::lanes_per_batch()})
            print_explicit_row(dimensions, lanes);
}

} // namespace
} // namespace culm::bench

int main() {
    return culm::bench::run_program([] {
        culm::bench::print_implicit();
        culm::bench::print_explicit();
    });
}
