// SPDX-License-Identifier: BSD-3-Clause
// Accuracy and cost of ARKODE's diagonally implicit methods on ring-downs of the published stem.
#include "bench/implicit_probe.hpp"
#include "bench/run_program.hpp"
#include "core/error.hpp"

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

/// A method under the number that ARKODE 6.4 gives its table (arkode_butcher_dirk.h). The numbers
/// stand here because only src/integrate may include SUNDIALS.
struct Method {
    std::string_view name;
    int butcher_table;
    int order;
    int implicit_stages;
};
constexpr Method chosen{"ARK436L2SA", 109, 4, 5};
constexpr Method cross_check{"ESDIRK547L2SA2", 122, 5, 6};
constexpr std::array methods{chosen,
                             Method{"ESDIRK436L2SA", 117, 4, 5},
                             Method{"ESDIRK43I6L2SA", 118, 4, 5},
                             Method{"QESDIRK436L2SA", 119, 4, 5},
                             Method{"ESDIRK437L2SA", 120, 4, 6},
                             Method{"ARK437L2SA", 112, 4, 6},
                             Method{"SDIRK_5_3_4", 107, 4, 5},
                             Method{"CASH_5_3_4", 106, 4, 5},
                             Method{"KVAERNO_5_3_4", 108, 4, 4},
                             Method{"KVAERNO_4_2_3", 103, 3, 3},
                             Method{"ARK324L2SA", 104, 3, 3},
                             Method{"ESDIRK324L2SA", 114, 3, 3},
                             Method{"ESDIRK325L2SA", 115, 3, 4},
                             Method{"TRBDF2", 102, 2, 2},
                             Method{"KVAERNO_7_4_5", 110, 5, 6},
                             Method{"ARK548L2SA", 111, 5, 7},
                             Method{"ARK548L2SAb", 113, 5, 7},
                             Method{"ESDIRK547L2SA", 121, 5, 6},
                             cross_check};
constexpr std::array tolerances{1e-4, 1e-5, 1e-6, 1e-7};

struct Case {
    double youngs_modulus;
    double damping;
};
constexpr std::array cases{Case{1e9, 1.0},  Case{1e9, 25.0},  Case{1e9, 200.0},
                           Case{10e9, 1.0}, Case{10e9, 25.0}, Case{10e9, 200.0}};

/// The fitted b1 and b2 must be this close to the reference.
constexpr double accuracy_wanted = 1e-3;

/// One method at one tolerance on one stem, beside the reference.
struct Outcome {
    bool is_complete = false;
    double steps_per_cycle = 0.0;
    double rhs_per_cycle = 0.0;
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
            static_cast<double>(probe->cost.rhs_evaluations) / cycles,
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
    ReleasedStem released;
    Probe probe;
};

/// culm's method at 1e-9, and how far a method of another order is from it.
Reference make_reference(const Case& stem) {
    ReleasedStem released(stem.youngs_modulus, stem.damping);
    ProbeOptions tight{.relative_tolerance = 1e-9, .cpu_budget = 120.0, .repeats = 1};
    const std::optional<Probe> reference = probe_ring_down(released, tight);
    if (!reference)
        throw core::NumericalError(core::FailureKind::SolverFailed, "no reference");
    tight.butcher_table = cross_check.butcher_table;
    const Outcome check = compare(probe_ring_down(released, tight), *reference);
    fmt::print("| {:>5.0f} | {:>4.0f} | {:>6.2f} | {:>8.5f} | {:>5.1f} | {:.1e} | {:.1e} | {:.1e} "
               "|\n",
               stem.youngs_modulus * 1e-9, stem.damping, reference->frequency,
               reference->decay_per_cycle, reference->cycles(), check.tip_error, check.decay_error,
               check.frequency_error);
    std::fflush(stdout);
    return {std::move(released), *reference};
}

std::vector<Reference> make_references() {
    fmt::print("Planar chain of 56 spheres, law schramm2019, released from {:.0f} mm, {:.1f} s of "
               "vibration.\n\nReferences: {} at tolerance 1e-9; the last three columns are the "
               "differences of {} at 1e-9.\n\n"
               "| Y/GPa | β | b2/Hz | b1 per cycle | cycles | tip | b1 | b2 |\n"
               "|---:|---:|---:|---:|---:|---:|---:|---:|\n",
               1e3 * tip_deflection, record_length, chosen.name, cross_check.name);
    std::vector<Reference> references;
    references.reserve(cases.size());
    for (const Case& stem : cases)
        references.push_back(make_reference(stem));
    return references;
}

Row measure(const Method& method, double tolerance, const std::vector<Reference>& references) {
    Row row;
    for (std::size_t k = 0; k < cases.size(); ++k)
        row[k] =
            compare(probe_ring_down(references[k].released, {.butcher_table = method.butcher_table,
                                                             .relative_tolerance = tolerance}),
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

void print_row(const Method& method, double tolerance, const Row& row) {
    const auto complete = std::count_if(row.begin(), row.end(),
                                        [](const Outcome& outcome) { return outcome.is_complete; });
    const Extent steps = extent(row, &Outcome::steps_per_cycle);
    const Extent rhs = extent(row, &Outcome::rhs_per_cycle);
    const Extent ms = extent(row, &Outcome::ms_per_cycle);
    fmt::print("| {:<14} | {} | {:.0e} | {}/{} | {:>5.0f} | {:>5.0f} | {:>6.0f} | {:>6.2f} | "
               "{:>6.2f} | {:.1e} | {:.1e} | {:.1e} |\n",
               method.name, method.order, tolerance, complete, cases.size(), steps.mean,
               steps.largest, rhs.mean, ms.mean, ms.largest,
               extent(row, &Outcome::tip_error).largest, extent(row, &Outcome::decay_error).largest,
               extent(row, &Outcome::frequency_error).largest);
    std::fflush(stdout);
}

/// The cheapest tolerance of a method with which every stem is accurate.
void print_choice(const Method& method, const std::array<Row, tolerances.size()>& rows) {
    std::optional<std::size_t> best;
    for (std::size_t t = 0; t < rows.size(); ++t) {
        if (!std::all_of(rows[t].begin(), rows[t].end(), is_accurate))
            continue;
        if (!best || extent(rows[t], &Outcome::ms_per_cycle).mean <
                         extent(rows[*best], &Outcome::ms_per_cycle).mean)
            best = t;
    }
    if (!best) {
        fmt::print("| {:<14} | none |\n", method.name);
        return;
    }
    fmt::print("| {:<14} | {:.0e} | {:>6.2f} |", method.name, tolerances[*best],
               extent(rows[*best], &Outcome::ms_per_cycle).mean);
    for (const Outcome& outcome : rows[*best])
        fmt::print(" {:>6.2f} |", outcome.ms_per_cycle);
    fmt::print("\n");
}

void run() {
    const std::vector<Reference> references = make_references();

    fmt::print("\nMeans and largest values over the six stems; errors are the largest. 'done': "
               "stems finished within the budget of {} s.\nms: least processor time of three "
               "runs.\n\n"
               "| method | order | tol | done | steps/cycle | worst | rhs/cycle | ms/cycle | worst "
               "| tip | b1 | b2 |\n|---|---|---|---|---:|---:|---:|---:|---:|---:|---:|---:|\n",
               ProbeOptions{}.cpu_budget);
    std::array<std::array<Row, tolerances.size()>, methods.size()> table;
    for (std::size_t m = 0; m < methods.size(); ++m) {
        for (std::size_t t = 0; t < tolerances.size(); ++t) {
            table[m][t] = measure(methods[m], tolerances[t], references);
            print_row(methods[m], tolerances[t], table[m][t]);
        }
    }

    fmt::print("\nThe cheapest tolerance at which b1 and b2 of every stem are within {} % of the "
               "reference; ms per cycle.\n\n| method | tol | mean |",
               100.0 * accuracy_wanted);
    for (const Case& stem : cases)
        fmt::print(" Y {:.0f}, β {:.0f} |", stem.youngs_modulus * 1e-9, stem.damping);
    fmt::print("\n|---|---|---:|---:|---:|---:|---:|---:|---:|\n");
    for (std::size_t m = 0; m < methods.size(); ++m)
        print_choice(methods[m], table[m]);

    fmt::print("\n{} stem by stem.\n\n| Y/GPa | β | tol | steps/cycle | rhs/step | ms/cycle | tip "
               "| b1 | b2 |\n|---:|---:|---|---:|---:|---:|---:|---:|---:|\n",
               chosen.name);
    for (std::size_t k = 0; k < cases.size(); ++k) {
        for (std::size_t t = 0; t < tolerances.size(); ++t) {
            const Outcome& outcome = table[0][t][k];
            fmt::print("| {:>2.0f} | {:>3.0f} | {:.0e} | {:>5.0f} | {:>4.1f} | {:>6.2f} | {:.1e} | "
                       "{:.1e} | {:.1e} |\n",
                       cases[k].youngs_modulus * 1e-9, cases[k].damping, tolerances[t],
                       outcome.steps_per_cycle, outcome.rhs_per_cycle / outcome.steps_per_cycle,
                       outcome.ms_per_cycle, outcome.tip_error, outcome.decay_error,
                       outcome.frequency_error);
        }
    }
}

} // namespace
} // namespace culm::bench

int main() {
    return culm::bench::run_program([] { culm::bench::run(); });
}
