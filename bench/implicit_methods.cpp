// SPDX-License-Identifier: BSD-3-Clause
// Accuracy and cost of implicit methods on ring-downs of the published stem: culm's Rosenbrock
// methods and the best of ARKODE's diagonally implicit ones.
#include "bench/implicit_probe.hpp"
#include "bench/run_program.hpp"
#include "core/error.hpp"
#include "tests/integrate/rosenbrock_methods.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/core.h>

namespace culm::bench {
namespace {

struct Candidate {
    std::string_view name;
    int order;
    Method method;
    std::vector<double> tolerances;
};

/// ARKODE counts the errors of bond histories and geometry too, so that equal tolerances do not
/// mean equal errors: compare at equal errors.
std::vector<Candidate> candidates() {
    const std::vector<double> rosenbrock{1e-4, 3e-5, 1e-5, 3e-6, 1e-6, 1e-7};
    const std::vector<double> sundials{1e-5, 2e-6, 1e-6, 1e-7};
    return {{"RODAS4", 4, rosenbrock_method<integrate::Rodas4>(), rosenbrock},
            {"RODAS4P", 4, rosenbrock_method<integrate::Rodas4p>(), rosenbrock},
            {"RODAS5", 5, rosenbrock_method<integrate::Rodas5>(), rosenbrock},
            {"RODAS5P", 5, rosenbrock_method<integrate::Rodas5p>(), rosenbrock},
            {"ESDIRK436L2SA", 4, arkode_method(), sundials},
            {"ARK436L2SA", 4, arkode_method("ARKODE_ARK436L2SA_DIRK_6_3_4"), sundials},
            {"QESDIRK436L2SA", 4, arkode_method("ARKODE_QESDIRK436L2SA_6_3_4"), sundials},
            {"ARK437L2SA", 4, arkode_method("ARKODE_ARK437L2SA_DIRK_7_3_4"), sundials},
            {"ESDIRK325L2SA", 3, arkode_method("ARKODE_ESDIRK325L2SA_5_2_3"), sundials}};
}

struct Case {
    double youngs_modulus;
    double damping;
};
constexpr std::array cases{Case{0.4e9, 1.0}, Case{1e9, 1.0},   Case{1e9, 25.0},  Case{1e9, 200.0},
                           Case{10e9, 1.0},  Case{10e9, 25.0}, Case{10e9, 200.0}};

/// The fitted b1 and b2 must be this close to the reference.
constexpr double accuracy_wanted = 1e-3;

/// One method at one tolerance on one stem, compared with the reference.
struct Outcome {
    bool is_complete = false;
    double steps_per_cycle = 0.0;
    double ms_per_cycle = 0.0;
    double tip_error = 0.0;
    double decay_error = 0.0; ///< of b1 per cycle, relative
    double frequency_error = 0.0;
};
using Row = std::array<Outcome, cases.size()>;

Outcome compare(const std::optional<Probe>& probe, const Probe& reference) {
    if (!probe)
        return {};
    const double cycles = reference.cycles();
    return {true,
            static_cast<double>(probe->cost.steps) / cycles,
            1e3 * probe->cpu_seconds / cycles,
            tip_error(*probe, reference),
            std::abs(probe->decay_per_cycle / reference.decay_per_cycle - 1.0),
            std::abs(probe->frequency / reference.frequency - 1.0)};
}

bool is_accurate(const Outcome& outcome) {
    return outcome.is_complete && outcome.decay_error <= accuracy_wanted &&
           outcome.frequency_error <= accuracy_wanted;
}

struct Reference {
    StartedStem released;
    Probe probe;
};

/// The default method at 1e-11, and its difference from ARKODE.
Reference make_reference(const Case& stem) {
    StartedStem released = released_stem(stem.youngs_modulus, stem.damping);
    const std::optional<Probe> reference = probe_ring_down(
        released, method_in_use(), {.tolerance = 1e-11, .cpu_budget = 120.0, .repeats = 1});
    if (!reference)
        throw core::NumericalError(core::FailureKind::SolverFailed, "no reference");
    const Outcome check =
        compare(probe_ring_down(released, arkode_method(),
                                {.tolerance = 1e-9, .cpu_budget = 120.0, .repeats = 1}),
                *reference);
    fmt::print("| {:>4.1f} | {:>3.0f} | {:>6.2f} | {:>8.5f} | {:>4.1f} | {:.1e} | {:.1e} | {:.1e} "
               "|\n",
               stem.youngs_modulus * 1e-9, stem.damping, reference->frequency,
               reference->decay_per_cycle, reference->cycles(), check.tip_error, check.decay_error,
               check.frequency_error);
    std::fflush(stdout);
    return {std::move(released), *reference};
}

std::vector<Reference> make_references() {
    fmt::print("Planar chain of 56 spheres, law schramm2019, released from {:.0f} mm, {:.1f} s of "
               "vibration.\n\nReferences: RODAS5 at tolerance 1e-11; the last three columns are "
               "the differences of ARKODE's ESDIRK436L2SA at 1e-9.\n\n"
               "| Y/GPa | β | b2/Hz | b1 per cycle | cycles | tip | b1 | b2 |\n"
               "|---:|---:|---:|---:|---:|---:|---:|---:|\n",
               1e3 * released_deflection, record_length);
    std::vector<Reference> references;
    references.reserve(cases.size());
    for (const Case& stem : cases)
        references.push_back(make_reference(stem));
    return references;
}

Row measure(const Method& method, double tolerance, const std::vector<Reference>& references) {
    Row row;
    for (std::size_t k = 0; k < cases.size(); ++k)
        row[k] = compare(probe_ring_down(references[k].released, method, {.tolerance = tolerance}),
                         references[k].probe);
    return row;
}

/// Largest and mean of one number over the complete runs of a row.
struct Extent {
    double mean = 0.0;
    double largest = 0.0;
};
Extent extent(const Row& row, double Outcome::*member) {
    Extent out;
    double complete = 0.0;
    for (const Outcome& outcome : row) {
        if (!outcome.is_complete)
            continue;
        complete += 1.0;
        out.mean += outcome.*member;
        out.largest = std::max(out.largest, outcome.*member);
    }
    out.mean /= std::max(complete, 1.0);
    return out;
}

void print_row(const Candidate& candidate, double tolerance, const Row& row) {
    const auto complete = std::count_if(row.begin(), row.end(),
                                        [](const Outcome& outcome) { return outcome.is_complete; });
    const Extent steps = extent(row, &Outcome::steps_per_cycle);
    const Extent ms = extent(row, &Outcome::ms_per_cycle);
    fmt::print("| {:<14} | {} | {:.0e} | {}/{} | {:>5.0f} | {:>5.0f} | {:>6.2f} | {:>6.2f} | "
               "{:.1e} | {:.1e} | {:.1e} |\n",
               candidate.name, candidate.order, tolerance, complete, cases.size(), steps.mean,
               steps.largest, ms.mean, ms.largest, extent(row, &Outcome::tip_error).largest,
               extent(row, &Outcome::decay_error).largest,
               extent(row, &Outcome::frequency_error).largest);
    std::fflush(stdout);
}

/// The cheapest tolerance of a method with which every stem is accurate.
void print_choice(const Candidate& candidate, const std::vector<Row>& rows) {
    std::optional<std::size_t> best;
    for (std::size_t t = 0; t < rows.size(); ++t) {
        if (!std::all_of(rows[t].begin(), rows[t].end(), is_accurate))
            continue;
        if (!best || extent(rows[t], &Outcome::ms_per_cycle).mean <
                         extent(rows[*best], &Outcome::ms_per_cycle).mean)
            best = t;
    }
    if (!best) {
        fmt::print("| {:<14} | none |\n", candidate.name);
        return;
    }
    fmt::print("| {:<14} | {:.0e} | {:>6.2f} |", candidate.name, candidate.tolerances[*best],
               extent(rows[*best], &Outcome::ms_per_cycle).mean);
    for (const Outcome& outcome : rows[*best])
        fmt::print(" {:>6.2f} |", outcome.ms_per_cycle);
    fmt::print("\n");
}

void run() {
    const std::vector<Reference> references = make_references();
    fmt::print("\nMeans and largest values over the {} stems; errors are the largest. 'done': "
               "stems finished within the budget of {} s.\nms: least processor time of three "
               "runs.\n\n"
               "| method | order | tol | done | steps/cycle | worst | ms/cycle | worst | tip | b1 "
               "| b2 |\n|---|---|---|---|---:|---:|---:|---:|---:|---:|---:|\n",
               cases.size(), ProbeOptions{}.cpu_budget);
    const std::vector<Candidate> all = candidates();
    std::vector<std::vector<Row>> table;
    for (const Candidate& candidate : all) {
        std::vector<Row>& rows = table.emplace_back();
        for (const double tolerance : candidate.tolerances) {
            rows.push_back(measure(candidate.method, tolerance, references));
            print_row(candidate, tolerance, rows.back());
        }
    }

    fmt::print("\nThe cheapest tolerance at which b1 and b2 of every stem are within {} % of the "
               "reference; ms per cycle.\n\n| method | tol | mean |",
               100.0 * accuracy_wanted);
    for (const Case& stem : cases)
        fmt::print(" Y {}, β {:.0f} |", stem.youngs_modulus * 1e-9, stem.damping);
    fmt::print("\n|---|---|---:|---:|---:|---:|---:|---:|---:|---:|\n");
    for (std::size_t m = 0; m < all.size(); ++m)
        print_choice(all[m], table[m]);
}

} // namespace
} // namespace culm::bench

int main() {
    return culm::bench::run_program([] { culm::bench::run(); });
}
