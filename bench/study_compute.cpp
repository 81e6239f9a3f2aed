// SPDX-License-Identifier: BSD-3-Clause
// The bare computation of a study in one process: no MPI, no journal, no archive, no regression.
// Prints "load simulate fit", seconds of processor time; bench/study_overhead.sh compares.
#include "bench/cpu_time.hpp"
#include "bench/run_program.hpp"
#include "core/error.hpp"
#include "run/simulate.hpp"
#include "study/execute/plan.hpp"
#include "study/execute/point_results.hpp"

#include <cstdint>
#include <cstdio>
#include <numeric>
#include <utility>
#include <vector>

#include <fmt/core.h>

namespace culm::bench {
namespace {

void compute(const char* file) {
    const double start = cpu_seconds();
    const study::Study study = study::load_study(file);
    std::vector<std::int64_t> points(static_cast<std::size_t>(study.design.point_count()));
    std::iota(points.begin(), points.end(), std::int64_t{0});
    const std::vector<farm::Batch> batches = study::make_batches(study, points);
    const double load = cpu_seconds() - start;

    double simulate = 0.0;
    double fit = 0.0;
    for (const farm::Batch& batch : batches) {
        std::vector<run::CaseSpec> specs;
        for (const std::int64_t point : batch.points)
            specs.push_back(study::case_of_point(study.config, study.design, point));
        const double begin = cpu_seconds();
        std::vector<run::CaseOutcome> outcomes = run::Simulator().simulate_together(specs);
        const double simulated = cpu_seconds();
        for (std::size_t k = 0; k < specs.size(); ++k)
            if (!study::make_record(specs[k], std::move(outcomes[k]), study.config.reduce)
                     .completed)
                throw core::NumericalError(core::FailureKind::SolverFailed,
                                           fmt::format("point {} failed", specs[k].point));
        simulate += simulated - begin;
        fit += cpu_seconds() - simulated;
    }
    fmt::print("{:.4f} {:.4f} {:.4f}\n", load, simulate, fit);
}

} // namespace
} // namespace culm::bench

int main(int argc, char** argv) {
    if (argc != 2) {
        std::fputs("use: bench_study_compute STUDY.toml\n", stderr);
        return 2;
    }
    return culm::bench::run_program([file = argv[1]] { culm::bench::compute(file); });
}
