// SPDX-License-Identifier: BSD-3-Clause
// Predicts the efficiency of the farm on many ranks from the real scheduler, measured run times and
// a stated network.
#include "bench/cpu_time.hpp"
#include "bench/run_program.hpp"
#include "bench/simulated_farm.hpp"
#include "farm/batch.hpp"
#include "farm/map_call.hpp"
#include "run/simulate.hpp"
#include "study/execute/plan.hpp"
#include "study/execute/point_results.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <numeric>
#include <random>
#include <utility>
#include <vector>

#include <fmt/core.h>

namespace culm::bench {
namespace {

/// Planned and measured processor time of a batch, s: one stem per SIMD lane, with its fits.
struct MeasuredBatch {
    double planned = 0.0;
    double seconds = 0.0;
};

std::vector<MeasuredBatch> measure_batches(const char* file) {
    constexpr int repeats = 5;
    const study::Study study = study::load_study(file);
    std::vector<std::int64_t> points(static_cast<std::size_t>(study.design.point_count()));
    std::iota(points.begin(), points.end(), std::int64_t{0});
    std::vector<MeasuredBatch> measured;
    for (const farm::Batch& batch : study::make_batches(study, points)) {
        std::vector<run::CaseSpec> specs;
        for (const std::int64_t point : batch.points)
            specs.push_back(study::case_of_point(study.config, study.design, point));
        const auto compute = [&] {
            std::vector<run::CaseOutcome> outcomes = run::Simulator().simulate_together(specs);
            for (std::size_t k = 0; k < specs.size(); ++k)
                (void)study::make_record(specs[k], std::move(outcomes[k]), study.config.reduce);
        };
        measured.push_back({batch.cost, time_repeats(repeats, compute).least()});
    }
    return measured;
}

double mean_seconds(const std::vector<MeasuredBatch>& measured) {
    double sum = 0.0;
    for (const MeasuredBatch& batch : measured)
        sum += batch.seconds;
    return sum / static_cast<double>(measured.size());
}

/// A study of `count` batches drawn from the measured ones, in the order of the plan.
struct DrawnStudy {
    std::vector<double> costs;
    std::vector<double> seconds;
};

DrawnStudy draw(const std::vector<MeasuredBatch>& measured, std::size_t count, double scale) {
    std::mt19937_64 random(1);
    std::uniform_int_distribution<std::size_t> pick(0, measured.size() - 1);
    std::vector<MeasuredBatch> batches(count);
    for (MeasuredBatch& batch : batches)
        batch = measured[pick(random)];
    std::ranges::sort(batches, std::ranges::greater{}, &MeasuredBatch::planned);
    DrawnStudy study;
    for (const MeasuredBatch& batch : batches) {
        study.costs.push_back(batch.planned);
        study.seconds.push_back(scale * batch.seconds);
    }
    return study;
}

/// Processor time of a rank at the start of a map, s: order, digest, initial ranges.
double opening_seconds(const DrawnStudy& study, int ranks) {
    std::vector<farm::Batch> batches;
    for (const double cost : study.costs)
        batches.push_back({{static_cast<std::int64_t>(batches.size())}, cost});
    const double start = cpu_seconds();
    const farm::Work work;
    const farm::FarmOptions options;
    const farm::MapCall call{
        batches, farm::plan_order(batches), work, options, farm::digest(batches), 0, ranks};
    const bool is_dealt = !call.dealt_scheduler().held_by(0).empty();
    return is_dealt ? cpu_seconds() - start : 0.0;
}

void print_table(const std::vector<MeasuredBatch>& measured, const FarmModel& network) {
    fmt::print(
        "Latency {:.0f} µs, {:.1f} µs of rank 0 per report and answer, {:.0f} µs between "
        "beats.\n\n"
        "| ms a batch | batches | ranks | batches a rank | makespan, s | bound, s | efficiency "
        "| with opening | messages/s | rank 0 in messages | largest delay, ms |\n"
        "|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|\n",
        1e6 * network.latency, 1e6 * network.handling, 1e6 * network.beat);
    for (const double scale : {1.0, 30.0, 300.0})
        for (const int ranks : {64, 1024, 16384})
            for (const double seconds_per_rank : {2.0, 60.0}) {
                const auto count = static_cast<std::size_t>(
                    std::ceil(seconds_per_rank * ranks / (scale * mean_seconds(measured))));
                const DrawnStudy study = draw(measured, count, scale);
                const double work =
                    std::accumulate(study.seconds.begin(), study.seconds.end(), 0.0);
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
        culm::bench::print_table(culm::bench::measure_batches(argv[1]), network);
    });
}
