// SPDX-License-Identifier: BSD-3-Clause
// The cost of the readings' error terms: processor time of a fit of the chain with them over that
// of a fit that treats inputs, noise, division and release as exact.
//
//   bench_reading_errors_cost MEASUREMENT...
#include "bench/cpu_time.hpp"
#include "fit/fit_model.hpp"
#include "measure/folder/measurement_folder.hpp"

#include <cmath>

#include <fmt/core.h>

int main(int argc, char** argv) {
    using namespace culm;
    fmt::print("| recording | exact, ms | with its errors, ms | ratio | runs |\n"
               "|---|---:|---:|---:|---:|\n");
    double logarithms = 0.0;
    for (int k = 1; k < argc; ++k) {
        const measure::Measurement measurement = measure::read_measurement(argv[k]);
        int exact_runs = 0;
        int runs = 0;
        const double exact =
            bench::time_repeats(5, [&] {
                exact_runs = fit::fit_model({}, {}, fit::observed({&measurement, 1})).runs;
            }).median();
        const double beside = bench::time_repeats(5, [&] {
                                  runs = fit::fit_baseline({&measurement, 1}).fit.runs;
                              }).median();
        logarithms += std::log(beside / exact);
        fmt::print("| {} | {:.0f} | {:.0f} | {:.2f} | {} and {} |\n", measurement.stem.id,
                   1e3 * exact, 1e3 * beside, beside / exact, exact_runs, runs);
    }
    fmt::print("| geometric mean | | | {:.2f} | |\n",
               std::exp(logarithms / static_cast<double>(argc - 1)));
    return 0;
}
