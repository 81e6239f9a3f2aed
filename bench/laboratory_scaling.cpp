// SPDX-License-Identifier: BSD-3-Clause
// Predicts the efficiency of the diagnosis of a laboratory on many ranks.
//
//   bench_laboratory_scaling STEMS FOLDER...
//
// The recordings are diagnosed once, on this process; every item of every map is timed, and so is
// the work between the maps, which every rank does. A laboratory of STEMS stems has the same maps
// with items drawn from the measured ones. A simulation around the real scheduler gives the time of
// each map, and a binomial tree the time in which the answers reach all ranks. The work between the
// maps is taken to grow in proportion to the stems.
#include "bench/cpu_time.hpp"
#include "bench/run_program.hpp"
#include "bench/simulated_farm.hpp"
#include "diagnose/diagnosis.hpp"
#include "fit/fit_model.hpp"
#include "measure/folder/measurement_folder.hpp"

#include <bit>
#include <cstdio>
#include <cstdlib>
#include <numeric>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include <fmt/core.h>

namespace culm::bench {
namespace {

/// Bytes per second of a link between two ranks.
constexpr double bandwidth = 5e9;

/// A map of the diagnosis.
struct MeasuredMap {
    std::vector<double> costs;   ///< (items)
    std::vector<double> seconds; ///< (items)
    double bytes = 0.0;          ///< of all answers
    double before = 0.0;         ///< s between the previous map and this one
};

struct MeasuredDiagnosis {
    std::size_t stems = 0;
    std::vector<MeasuredMap> maps;
    double after = 0.0; ///< s behind the last map
};

MeasuredDiagnosis measure(const std::vector<std::string>& folders) {
    const measure::MeasurementSet read = measure::read_measurements(folders);
    const auto specimens = diagnose::specimens_of(read.measurements);
    MeasuredDiagnosis measured{specimens.size(), {}, 0.0};
    double last = cpu_seconds();
    diagnose::DiagnosisOptions options;
    options.candidates = fit::candidate_effects(read.measurements);
    options.map = core::ItemMap(
        [&](const std::vector<double>& costs, const core::ItemMap::EncodedWork& work) {
            MeasuredMap map{costs, {}, 0.0, cpu_seconds() - last};
            std::vector<core::ItemOutcome<core::Bytes>> outcomes(costs.size());
            for (std::size_t item = 0; item < costs.size(); ++item) {
                const double start = cpu_seconds();
                outcomes[item].value = work(item, {}).bytes;
                map.seconds.push_back(cpu_seconds() - start);
                map.bytes += static_cast<double>(outcomes[item].value->size());
            }
            measured.maps.push_back(std::move(map));
            last = cpu_seconds();
            return outcomes;
        });
    const diagnose::Diagnosis found = diagnose::diagnose(specimens, options);
    measured.after = cpu_seconds() - last;
    fmt::print("{} stems, {} maps: {}\n\n", measured.stems, measured.maps.size(), found.reason);
    return measured;
}

/// Items of a larger laboratory, the costliest first.
std::vector<std::pair<double, double>> drawn_items(const MeasuredMap& map, std::size_t count) {
    std::mt19937_64 random(1);
    std::uniform_int_distribution<std::size_t> pick(0, map.costs.size() - 1);
    std::vector<std::pair<double, double>> items;
    for (std::size_t k = 0; k < count; ++k) {
        const std::size_t item = pick(random);
        items.emplace_back(map.costs[item], map.seconds[item]);
    }
    std::ranges::sort(items, std::ranges::greater{}, &std::pair<double, double>::first);
    return items;
}

void print_line(const MeasuredDiagnosis& measured, std::size_t stems, int ranks) {
    const double scale = static_cast<double>(stems) / static_cast<double>(measured.stems);
    const double depth = std::bit_width(static_cast<unsigned>(ranks - 1));
    double work = 0.0;
    double maps = 0.0;
    double broadcast = 0.0;
    double between = scale * measured.after;
    for (const MeasuredMap& map : measured.maps) {
        between += scale * map.before;
        broadcast += depth * scale * map.bytes / bandwidth;
        std::vector<double> costs;
        std::vector<double> seconds;
        const auto count = static_cast<std::size_t>(scale * static_cast<double>(map.costs.size()));
        for (const auto& [cost, second] : drawn_items(map, count)) {
            costs.push_back(cost);
            seconds.push_back(second);
        }
        FarmModel model;
        model.ranks = ranks;
        model.chunk_seconds = 0.0;
        maps += simulate_farm(costs, seconds, model).makespan;
        work += std::accumulate(seconds.begin(), seconds.end(), 0.0);
    }
    const double wall = maps + broadcast + between;
    fmt::print("| {} | {} | {:.0f} | {:.1f} | {:.1f} | {:.2f} | {:.2f} | {:.1f} % |\n", stems,
               ranks, work, wall, maps, broadcast, between, 100.0 * work / (ranks * wall));
}

} // namespace
} // namespace culm::bench

int main(int argc, char** argv) {
    if (argc < 3) {
        std::fputs("use: bench_laboratory_scaling STEMS FOLDER...\n", stderr);
        return 2;
    }
    return culm::bench::run_program([&] {
        const culm::bench::MeasuredDiagnosis measured =
            culm::bench::measure({argv + 2, argv + argc});
        fmt::print("| stems | ranks | work, s | wall, s | in maps | in broadcasts | between maps "
                   "| efficiency |\n|---:|---:|---:|---:|---:|---:|---:|---:|\n");
        const auto stems = static_cast<std::size_t>(std::atoll(argv[1]));
        for (const int ranks : {2, 16, 64, 256, 1024})
            culm::bench::print_line(measured, stems, ranks);
    });
}
