// SPDX-License-Identifier: BSD-3-Clause
// The cost of a stem alone, in a batch of SIMD lanes, and with derivatives by its parameters.
#include "bench/cpu_time.hpp"
#include "bench/run_program.hpp"
#include "core/error.hpp"
#include "core/lanes.hpp"
#include "integrate/modes.hpp"
#include "integrate/statics.hpp"
#include "run/sensitivities.hpp"
#include "run/simulate.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <string_view>
#include <variant>
#include <vector>

#include <fmt/core.h>

namespace culm::bench {
namespace {

constexpr int repeats = 5;
constexpr std::array youngs_moduli{0.4e9, 1e9, 10e9};
constexpr std::array dampings{1.0, 25.0, 200.0};

run::CaseSpec stem_case(int dimensions, double youngs_modulus, double damping) {
    run::CaseSpec spec;
    spec.dimensions = dimensions;
    spec.stem.bond_youngs_modulus = youngs_modulus;
    spec.stem.bond_damping = damping;
    return spec;
}

double cycles(const run::CaseSpec& spec) {
    return spec.duration *
           integrate::vibration_modes(integrate::linearise_transverse(spec.stem, spec.law), 1)
               .at(0)
               .frequency;
}

const run::CaseResult& completed(const run::CaseOutcome& outcome) {
    if (const auto* failure = std::get_if<run::CaseFailure>(&outcome))
        throw core::NumericalError(failure->kind, failure->reason);
    return std::get<run::CaseResult>(outcome);
}

/// Processor time of a call, s, least of the repeats.
template <class Work>
double seconds_of(Work&& work) {
    return time_repeats(repeats, work).least();
}

/// One stem per lane, of the same β, or of β from 25 to 200 as in the design.
std::vector<run::CaseSpec> batch_of(const run::CaseSpec& first, bool is_design) {
    std::vector<run::CaseSpec> specs(run::lanes_per_batch(), first);
    for (std::size_t k = 0; k < specs.size(); ++k) {
        const auto place = static_cast<double>(k) / static_cast<double>(specs.size());
        if (is_design)
            specs[k].stem.bond_damping = 25.0 + 175.0 * place;
        else
            specs[k].stem.bond_youngs_modulus *= 1.0 + 0.1 * place;
    }
    return specs;
}

template <int Dim>
double static_start_seconds() {
    const physics::Chain<Dim, double> chain(physics::StemParameters<double>{},
                                            physics::schramm2019_law());
    return seconds_of([&] { (void)integrate::deflected_equilibrium(chain, 15e-3); });
}

double static_start_seconds(int dimensions) {
    return dimensions == 2 ? static_start_seconds<2>() : static_start_seconds<3>();
}

/// Cost of stems that run together, ms per cycle and stem.
struct CycleCost {
    double all = 0.0;       ///< static start included
    double vibration = 0.0; ///< without it
};
CycleCost cost_of(const std::vector<run::CaseSpec>& specs, double static_start) {
    double all_cycles = 0.0;
    for (const run::CaseSpec& spec : specs)
        all_cycles += cycles(spec);
    const double seconds = seconds_of([&] {
        if (specs.size() == 1)
            (void)completed(run::simulate(specs.front()));
        else
            for (const run::CaseOutcome& outcome : run::Simulator().simulate_together(specs))
                (void)completed(outcome);
    });
    return {1e3 * seconds / all_cycles,
            1e3 * (seconds - static_cast<double>(specs.size()) * static_start) / all_cycles};
}

void print_stems(int dimensions) {
    const double static_start = static_start_seconds(dimensions);
    fmt::print("\n### {}: one stem, and batches of {}\n\nA static start takes {:.2f} ms.\n\n"
               "| Y/GPa | β | steps/cycle | one stem, ms/cycle | with static start | batch of like "
               "stems, ms/cycle and stem | with static start | ratio |\n"
               "|---:|---:|---:|---:|---:|---:|---:|---:|\n",
               dimensions == 2 ? "Planar" : "Spatial", run::lanes_per_batch(), 1e3 * static_start);
    for (const double youngs_modulus : youngs_moduli)
        for (const double damping : dampings) {
            const run::CaseSpec spec = stem_case(dimensions, youngs_modulus, damping);
            const auto steps =
                static_cast<double>(completed(run::simulate(spec)).work.steps) / cycles(spec);
            const CycleCost alone = cost_of({spec}, static_start);
            const CycleCost together = cost_of(batch_of(spec, false), static_start);
            fmt::print("| {} | {:.0f} | {:.1f} | {:.2f} | {:.2f} | {:.3f} | {:.3f} | {:.2f} |\n",
                       youngs_modulus * 1e-9, damping, steps, alone.vibration, alone.all,
                       together.vibration, together.all, alone.vibration / together.vibration);
            std::fflush(stdout);
        }
    for (const double youngs_modulus : youngs_moduli) {
        const CycleCost mixed =
            cost_of(batch_of(stem_case(dimensions, youngs_modulus, 25.0), true), static_start);
        fmt::print("| {} | 25 … 178 in one batch | | | | {:.3f} | {:.3f} | |\n",
                   youngs_modulus * 1e-9, mixed.vibration, mixed.all);
    }
}

/// d(tip)/d(parameter) by a central difference of two runs at a tolerance of 1e-10.
std::vector<double> central_difference(const run::CaseSpec& spec,
                                       const run::CaseParameter& parameter) {
    const double change = 1e-4 * parameter.get(spec);
    run::CaseSpec ahead = spec;
    ahead.integrator.relative_tolerance = 1e-10;
    run::CaseSpec behind = ahead;
    parameter.set(ahead, parameter.get(spec) + change);
    parameter.set(behind, parameter.get(spec) - change);
    std::vector<double> out = completed(run::simulate(ahead)).tip_deflection;
    const std::vector<double> other = completed(run::simulate(behind)).tip_deflection;
    for (std::size_t k = 0; k < out.size(); ++k)
        out[k] = (out[k] - other[k]) / (2.0 * change);
    return out;
}

double relative_difference(const std::vector<double>& found, const std::vector<double>& expected) {
    double largest = 0.0;
    double worst = 0.0;
    for (std::size_t k = 0; k < expected.size(); ++k) {
        largest = std::max(largest, std::abs(expected[k]));
        worst = std::max(worst, std::abs(found[k] - expected[k]));
    }
    return worst / largest;
}

void print_sensitivities() {
    const std::vector<run::CaseParameter> parameters = run::baseline_parameters();
    fmt::print("\n### Derivatives by Y, β and the released deflection (planar, default "
               "tolerance)\n\nms of processor time a run; errors of d(tip)/d(parameter) against "
               "central differences at 1e-10, relative to its largest value.\n\n"
               "| Y/GPa | β | one run | run with derivatives | / one run | / (1 + 3 runs) | a "
               "derivative, in runs | d/dY | d/dβ | d/dδ |\n"
               "|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|\n");
    for (const double youngs_modulus : youngs_moduli)
        for (const double damping : dampings) {
            run::CaseSpec spec = stem_case(2, youngs_modulus, damping);
            spec.store = run::StoreLevel::Heights;
            spec.heights = {spec.stem.free_length()};
            spec.reading = measure::Reading::Material; // a mark at the tip
            const double plain = seconds_of([&] { (void)completed(run::simulate(spec)); });
            run::SensitivityOutcome outcome;
            const double with =
                seconds_of([&] { outcome = run::simulate_with_sensitivities(spec, parameters); });
            const auto& found = std::get<run::CaseWithSensitivities>(outcome).height_derivatives;
            const auto count = static_cast<double>(parameters.size());
            fmt::print("| {} | {:.0f} | {:.2f} | {:.2f} | {:.2f} | {:.2f} | {:.2f} |",
                       youngs_modulus * 1e-9, damping, 1e3 * plain, 1e3 * with, with / plain,
                       with / (plain * (1.0 + count)), (with / plain - 1.0) / count);
            for (std::size_t p = 0; p < parameters.size(); ++p)
                fmt::print(" {:.0e} |",
                           relative_difference(found[p], central_difference(spec, parameters[p])));
            fmt::print("\n");
            std::fflush(stdout);
        }
}

void run_all() {
    const run::CaseSpec defaults;
    fmt::print("56 spheres, {:.1f} s of vibration, tolerance {:.0e}, static start and sampling "
               "included; least processor time of {} repeats; {} SIMD lanes.\nA static start "
               "takes {:.2f} ms in the plane, {:.2f} ms in space.\n",
               defaults.duration, defaults.integrator.relative_tolerance, repeats, core::lane_count,
               1e3 * static_start_seconds<2>(), 1e3 * static_start_seconds<3>());
    print_stems(2);
    print_stems(3);
    print_sensitivities();
}

} // namespace
} // namespace culm::bench

int main() {
    return culm::bench::run_program([] { culm::bench::run_all(); });
}
