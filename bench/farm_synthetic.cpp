// SPDX-License-Identifier: BSD-3-Clause
#include "bench/farm_synthetic.hpp"

#include "bench/cpu_time.hpp"
#include "run/simulate.hpp"
#include "study/execute/plan.hpp"
#include "study/execute/point_results.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <utility>

#include <fmt/core.h>
#include <sys/resource.h>

namespace culm::bench {

namespace {

std::string sobol_study(const std::string& store, std::int64_t points) {
    return fmt::format("[study]\n"
                       "name = \"bench\"\n"
                       "store = \"{}\"\n"
                       "{}"
                       "[integrator]\n"
                       "method = \"implicit\"\n"
                       "[vibration]\n"
                       "duration_s = 0.1\n"
                       "sample_interval_s = 5e-5\n"
                       "[factors]\n"
                       "bond_damping = {{ from = 25, to = 200 }}\n"
                       "bond_youngs_modulus_gpa = {{ from = 1, to = 10 }}\n"
                       "[design]\n"
                       "type = \"sobol\"\n"
                       "points = {}\n",
                       store, store == "heights" ? "heights_mm = [40, 80, 120]\n" : "", points);
}

/// Processor time of a point, from a few batches.
double seconds_per_point(const std::string& store) {
    constexpr std::int64_t samples = 32;
    const study::Study study = study::parse_study(sobol_study(store, samples), "sample.toml");
    std::vector<std::int64_t> points(samples);
    std::iota(points.begin(), points.end(), std::int64_t{0});
    const double start = cpu_seconds();
    for (const farm::Batch& batch : study::make_batches(study, points)) {
        std::vector<run::CaseSpec> specs;
        for (const std::int64_t point : batch.points)
            specs.push_back(study::case_of_point(study.config, study.design, point));
        std::vector<run::CaseOutcome> outcomes = run::Simulator().simulate_together(specs);
        for (std::size_t k = 0; k < specs.size(); ++k)
            (void)study::make_record(specs[k], std::move(outcomes[k]), study.config.reduce);
    }
    return (cpu_seconds() - start) / static_cast<double>(samples);
}

} // namespace

SyntheticWork synthetic_work() {
    constexpr int count = 1000;
    constexpr double mean = 0.02;
    constexpr double spread = 0.5;
    constexpr double misjudgement = 0.2;
    std::mt19937_64 random(1);
    std::normal_distribution<double> normal;
    SyntheticWork work;
    for (int k = 0; k < count; ++k) {
        const double seconds = mean * std::exp(spread * normal(random) - 0.5 * spread * spread);
        work.seconds.push_back(seconds);
        work.batches.push_back({{k}, seconds * std::exp(misjudgement * normal(random))});
    }
    return work;
}

std::vector<farm::Batch> trivial_batches(std::int64_t points) {
    std::vector<farm::Batch> batches;
    batches.reserve(static_cast<std::size_t>(points));
    for (std::int64_t point = 0; point < points; ++point)
        batches.push_back({{point}, 1.0});
    return batches;
}

std::string study_text(const std::string& store, double seconds) {
    const double points = std::ceil(seconds / seconds_per_point(store));
    return sobol_study(store, static_cast<std::int64_t>(points));
}

std::string trivial_study_text(std::int64_t points) {
    return sobol_study("fit", points);
}

archive::PointRecord trivial_record(const run::CaseSpec& spec, std::size_t columns) {
    archive::PointRecord record;
    record.point = spec.point;
    record.completed = true;
    record.values.assign(columns, static_cast<double>(spec.point));
    return record;
}

double largest_resident_megabytes() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return 1e-3 * 1.024 * static_cast<double>(usage.ru_maxrss);
}

} // namespace culm::bench
