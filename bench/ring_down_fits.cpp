// SPDX-License-Identifier: BSD-3-Clause
// The cost of a fit of Eq. 1: all tip histories of an archived study are fitted again.
#include "archive/study/file.hpp"
#include "bench/cpu_time.hpp"
#include "bench/run_program.hpp"
#include "reduce/ring_down/ring_down_fit.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <vector>

#include <fmt/core.h>

namespace culm::bench {
namespace {

constexpr int repeats = 7;

void fit_all(const char* folder) {
    const archive::StudyFile file(std::filesystem::path(folder) / "study.h5");
    const std::vector<double>& times = file.description().times;
    std::vector<std::vector<double>> histories;
    std::vector<std::int64_t> points;
    for (std::int64_t point = 0; point < file.point_count(); ++point)
        if (file.status(point) == archive::PointStatus::Completed) {
            points.push_back(point);
            histories.push_back(file.tip_deflection(point));
        }

    std::vector<reduce::RingDownFit> fits(histories.size());
    const Timings timings = time_repeats(repeats, [&] {
        for (std::size_t k = 0; k < histories.size(); ++k)
            fits[k] = reduce::fit_ring_down(times, histories[k]);
    });

    // Compares with the archive, which an earlier build may have written.
    const std::vector<double> frequency = file.result("frequency");
    const std::vector<double> decay = file.result("decay_per_cycle");
    const std::vector<double> error = file.result("frequency_standard_error");
    double difference = 0.0;
    for (std::size_t k = 0; k < fits.size(); ++k) {
        const auto relative = [&](double now, const std::vector<double>& column) {
            const double then = column[static_cast<std::size_t>(points[k])];
            return std::abs(now - then) / std::abs(then);
        };
        difference = std::max({difference, relative(fits[k].frequency.value, frequency),
                               relative(fits[k].decay_per_cycle.value, decay),
                               relative(fits[k].frequency.standard_error, error)});
    }
    const double per_fit = 1e3 / static_cast<double>(fits.size());
    fmt::print("{} fits of {} samples: {:.3f} ms each (median of {} repeats), least {:.3f} ms; "
               "largest relative difference from the archive {:.1e}\n",
               fits.size(), times.size(), per_fit * timings.median(), repeats,
               per_fit * timings.least(), difference);
}

} // namespace
} // namespace culm::bench

int main(int argc, char** argv) {
    if (argc != 2) {
        std::fputs("use: bench_ring_down_fits STUDY_FOLDER (with store = \"tip\" or more)\n",
                   stderr);
        return 2;
    }
    return culm::bench::run_program([folder = argv[1]] { culm::bench::fit_all(folder); });
}
