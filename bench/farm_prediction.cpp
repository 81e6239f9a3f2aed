// SPDX-License-Identifier: BSD-3-Clause
// Efficiency of the farm on many ranks, predicted: the real scheduler, run times measured here, and
// a stated network.
#include "bench/cpu_time.hpp"
#include "bench/run_program.hpp"
#include "bench/simulated_farm.hpp"
#include "farm/batch.hpp"
#include "farm/map_call.hpp"
#include "run/simulate.hpp"
#include "study/plan.hpp"
#include "study/point_results.hpp"

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <numeric>
#include <random>
#include <utility>
#include <vector>

#include <fmt/core.h>

namespace culm::bench {
namespace {

/// Planned and measured processor time of a point, s.
struct MeasuredPoint {
    double planned = 0.0;
    double seconds = 0.0;
};

std::vector<MeasuredPoint> measure_points(const char* file) {
    constexpr int repeats = 2;
    const study::Study study = study::load_study(file);
    std::vector<MeasuredPoint> points;
    for (std::int64_t point = 0; point < study.design.point_count(); ++point) {
        const run::CaseSpec spec = study::case_of_point(study.config, study.design, point);
        MeasuredPoint measured{study::estimated_seconds(spec),
                               std::numeric_limits<double>::infinity()};
        for (int k = 0; k < repeats; ++k) {
            const double start = cpu_seconds();
            (void)study::make_record(spec, run::simulate(spec), study.config.reduce);
            measured.seconds = std::min(measured.seconds, cpu_seconds() - start);
        }
        points.push_back(measured);
    }
    return points;
}

/// A study of `count` points drawn from the measured ones, in the order of the plan.
struct DrawnStudy {
    std::vector<double> costs;
    std::vector<double> seconds;
};

DrawnStudy draw(const std::vector<MeasuredPoint>& measured, std::size_t count, double scale) {
    std::mt19937_64 random(1);
    std::uniform_int_distribution<std::size_t> pick(0, measured.size() - 1);
    std::vector<MeasuredPoint> points(count);
    for (MeasuredPoint& point : points)
        point = measured[pick(random)];
    std::ranges::sort(points, std::ranges::greater{}, &MeasuredPoint::planned);
    DrawnStudy study;
    for (const MeasuredPoint& point : points) {
        study.costs.push_back(point.planned);
        study.seconds.push_back(scale * point.seconds);
    }
    return study;
}

/// What every rank does at the start of a map, s of processor time: order, digest, opening hand.
double opening_seconds(const DrawnStudy& study, int ranks) {
    std::vector<farm::Batch> batches;
    for (const double cost : study.costs)
        batches.push_back({{static_cast<std::int64_t>(batches.size())}, cost});
    const double start = cpu_seconds();
    const farm::Work work;
    const farm::FarmOptions options;
    const farm::MapCall call{
        batches, farm::plan_order(batches), work, options, farm::digest(batches), 1, 0, ranks};
    const bool is_dealt = !call.dealt_scheduler().held_by(0).empty();
    return is_dealt ? cpu_seconds() - start : 0.0;
}

void print_table(const std::vector<MeasuredPoint>& measured, const FarmModel& network) {
    fmt::print(
        "Latency {:.0f} µs, {:.1f} µs of rank 0 per report and answer, {:.0f} µs between "
        "beats.\n\n"
        "| ms a point | points | ranks | points a rank | makespan, s | bound, s | efficiency "
        "| with opening | messages/s | rank 0 in messages | largest delay, ms |\n"
        "|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|\n",
        1e6 * network.latency, 1e6 * network.handling, 1e6 * network.beat);
    for (const double scale : {1.0, 0.1})
        for (const std::size_t count : {std::size_t{100'000}, std::size_t{1'000'000}}) {
            const DrawnStudy study = draw(measured, count, scale);
            const double work = std::accumulate(study.seconds.begin(), study.seconds.end(), 0.0);
            for (const int ranks : {64, 1024, 16384}) {
                FarmModel model = network;
                model.ranks = ranks;
                model.seconds_per_cost = scale; // as study::execute has it, if costs were right
                const FarmPrediction found = simulate_farm(study.costs, study.seconds, model);
                const double bound = std::max(found.longest_batch, work / ranks);
                const double opening = opening_seconds(study, ranks);
                fmt::print("| {:.1f} | {} | {} | {:.0f} | {:.2f} | {:.2f} | {:.1f} % | {:.1f} % | "
                           "{:.0f} | {:.1f} % | {:.2f} |\n",
                           1e3 * work / static_cast<double>(count), count, ranks,
                           static_cast<double>(count) / ranks, found.makespan, bound,
                           100.0 * found.efficiency,
                           100.0 * found.efficiency * found.makespan / (found.makespan + opening),
                           static_cast<double>(found.messages) / found.makespan,
                           100.0 * found.coordinator_share, 1e3 * found.largest_delay);
            }
        }
}

} // namespace
} // namespace culm::bench

int main(int argc, char** argv) {
    if (argc != 2 && argc != 4) {
        std::fputs("use: bench_farm_prediction STUDY.toml [LATENCY_US HANDLING_US]\n", stderr);
        return 2;
    }
    return culm::bench::run_program([&] {
        culm::bench::FarmModel network;
        if (argc == 4) {
            network.latency = 1e-6 * std::atof(argv[2]);
            network.handling = 1e-6 * std::atof(argv[3]);
        }
        culm::bench::print_table(culm::bench::measure_points(argv[1]), network);
    });
}
