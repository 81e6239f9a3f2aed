// SPDX-License-Identifier: BSD-3-Clause
// The effect of the implicit integrator's tolerance on b1, b2 and the cost, over the range of
// stems: the measurement behind its default.
#include "bench/implicit_probe.hpp"
#include "bench/run_program.hpp"
#include "core/error.hpp"
#include "tests/support/modal_state.hpp"

#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <string>
#include <vector>

#include <fmt/core.h>

namespace culm::bench {
namespace {

constexpr std::array youngs_moduli{0.4e9, 1e9, 2e9, 4e9, 10e9};
constexpr std::array dampings{1.0, 2.0, 5.0, 10.0, 25.0, 50.0, 100.0, 200.0};
constexpr std::array tolerances{1e-7, 3e-7, 1e-6, 2e-6, 3e-6, 5e-6, 1e-5};

/// One stem of the range, started in both ways, and the exact b1 and b2.
struct Subject {
    double youngs_modulus;
    double damping;
    StartedStem modal; ///< in its first mode, so small that the chain is linear
    double frequency;  ///< of the linearised chain
    double decay_per_cycle;
    StartedStem released;
    Probe released_reference;
};

StartedStem in_first_mode(const physics::StemParameters<double>& stem,
                          std::complex<double>& eigenvalue) {
    // The geometric nonlinearity changes the frequency by about (δ/L)² = 4e-7.
    constexpr double deflection = 1e-4;
    const auto law = physics::schramm2019_law();
    const physics::Chain<2, double> chain(stem, law);
    const auto mode =
        tests::first_mode_state(chain, integrate::linearise_transverse(stem, law), deflection);
    eigenvalue = mode.eigenvalue;
    return {stem, mode.state, deflection};
}

Subject make_subject(double youngs_modulus, double damping) {
    std::complex<double> eigenvalue;
    StartedStem modal = in_first_mode(published_stem(youngs_modulus, damping), eigenvalue);
    const double frequency = eigenvalue.imag() / (2.0 * std::numbers::pi);
    StartedStem released = released_stem(youngs_modulus, damping);
    const auto reference = probe_ring_down(released, method_in_use(),
                                           {.tolerance = 1e-10, .cpu_budget = 60.0, .repeats = 1});
    if (!reference)
        throw core::NumericalError(core::FailureKind::SolverFailed, "no reference");
    return {
        youngs_modulus,      damping,   std::move(modal), frequency, eigenvalue.real() / frequency,
        std::move(released), *reference};
}

/// The largest value so far and its stem.
struct Worst {
    double value = 0.0;
    std::string stem;

    void take(double candidate, const Subject& subject) {
        if (!(candidate <= value)) {
            value = candidate;
            stem = fmt::format("{}, {}", subject.youngs_modulus * 1e-9, subject.damping);
        }
    }
};

Probe probed(const StartedStem& start, double tolerance) {
    const auto probe = probe_ring_down(start, method_in_use(), {.tolerance = tolerance});
    if (!probe)
        throw core::NumericalError(core::FailureKind::SolverFailed, "a run failed");
    return *probe;
}

void print_row(const std::vector<Subject>& subjects, double tolerance) {
    Worst modal_b1;
    Worst modal_b2;
    Worst b1;
    Worst b2;
    Worst tip;
    Worst ms;
    for (const Subject& subject : subjects) {
        const Probe small = probed(subject.modal, tolerance);
        modal_b1.take(std::abs(small.decay_per_cycle / subject.decay_per_cycle - 1.0), subject);
        modal_b2.take(std::abs(small.frequency / subject.frequency - 1.0), subject);
        const Probe large = probed(subject.released, tolerance);
        const Probe& reference = subject.released_reference;
        b1.take(std::abs(large.decay_per_cycle / reference.decay_per_cycle - 1.0), subject);
        b2.take(std::abs(large.frequency / reference.frequency - 1.0), subject);
        tip.take(tip_error(large, reference), subject);
        ms.take(1e3 * large.cpu_seconds / large.cycles(), subject);
    }
    fmt::print("| {:.0e} |", tolerance);
    for (const Worst* worst : {&modal_b1, &modal_b2, &b1, &b2, &tip})
        fmt::print(" {:.1e} ({}) |", worst->value, worst->stem);
    fmt::print(" {:.2f} ({}) |\n", ms.value, ms.stem);
    std::fflush(stdout);
}

void run() {
    std::vector<Subject> subjects;
    for (const double youngs_modulus : youngs_moduli)
        for (const double damping : dampings)
            subjects.push_back(make_subject(youngs_modulus, damping));
    fmt::print("Worst of {} stems (Y 0.4 to 10 GPa, β 1 to 200), and in brackets which (Y/GPa, "
               "β).\nIn the first mode at 0.1 mm: relative errors against the eigenvalue of the "
               "linearised chain. Released from 15 mm: against tolerance 1e-10.\n\n"
               "| tolerance | first mode, b1 | b2 | released, b1 | b2 | tip | ms per cycle |\n"
               "|---|---|---|---|---|---|---|\n",
               subjects.size());
    for (const double tolerance : tolerances)
        print_row(subjects, tolerance);
}

} // namespace
} // namespace culm::bench

int main() {
    return culm::bench::run_program([] { culm::bench::run(); });
}
