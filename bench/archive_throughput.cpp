// SPDX-License-Identifier: BSD-3-Clause
// The cost of committing a point and of writing the study file, without any computation.
#include "archive/journal/read.hpp"
#include "archive/journal/writer.hpp"
#include "archive/study/writer.hpp"
#include "archive/trajectory/writer.hpp"
#include "bench/cpu_time.hpp"
#include "bench/run_program.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include <fmt/core.h>

namespace culm::bench {
namespace {

constexpr std::size_t samples = 2001;
constexpr std::size_t spheres = 56;
const char* const identity = "bench";

/// The data that a study stores for each point.
struct Level {
    const char* name;
    std::int64_t points;
    std::size_t heights; ///< 0: none
    bool has_tip;
    bool has_positions;
};

archive::StudyDescription description_of(const Level& level) {
    archive::StudyDescription description;
    description.points = level.points;
    description.factors = {{"bond_damping", "1", ""}, {"bond_youngs_modulus_gpa", "GPa", ""}};
    for (int k = 0; k < 12; ++k)
        description.results.push_back({fmt::format("result_{}", k), "1", ""});
    description.stored = {level.has_tip, level.heights > 0, level.has_positions};
    for (std::size_t k = 0; k < samples; ++k)
        description.times.push_back(5e-5 * static_cast<double>(k));
    for (std::size_t k = 0; k < level.heights; ++k)
        description.heights.push_back(0.02 * static_cast<double>(k + 1));
    description.spheres = spheres;
    description.identity = identity;
    return description;
}

/// A ring-down like that of an integrator: no two values share their last bits.
double deflection(std::size_t sample, double place) {
    const double time = 5e-5 * static_cast<double>(sample);
    return 15e-3 * place * place * std::exp(-9.0 * time) * std::cos(358.0 * time + 0.1 * place);
}

archive::PointRecord record_of(const Level& level) {
    archive::PointRecord record;
    record.completed = true;
    for (int k = 0; k < 12; ++k)
        record.values.push_back(std::sqrt(1.0 + k));
    for (std::size_t k = 0; k < samples; ++k) {
        if (level.has_tip)
            record.tip_deflection.push_back(deflection(k, 1.0));
        for (std::size_t h = 0; h < level.heights; ++h)
            record.height_deflection.push_back(
                deflection(k, static_cast<double>(h + 1) / static_cast<double>(level.heights + 1)));
        for (std::size_t s = 0; level.has_positions && s < spheres; ++s) {
            const double place = static_cast<double>(s) / (spheres - 1.0);
            record.positions.insert(record.positions.end(),
                                    {2.83e-3 * static_cast<double>(s), deflection(k, place), 0.0});
        }
    }
    return record;
}

struct Costs {
    double append = 0.0; ///< s, as all of them
    double scan = 0.0;
    double read = 0.0;
    double hdf5 = 0.0;
    double bytes = 0.0;       ///< of journal and trajectories
    double study_bytes = 0.0; ///< of study.h5
};

Costs measure(const Level& level, const std::filesystem::path& folder) {
    const std::filesystem::path journals = folder / "journal";
    std::filesystem::remove_all(folder);
    archive::PointRecord record = record_of(level);
    Costs costs;
    double start = cpu_seconds();
    {
        const archive::StudyDescription description = description_of(level);
        archive::TrajectoryWriter trajectories(folder / "trajectories", 0, description,
                                               level.points);
        archive::JournalWriter journal(journals / "rank-00000.culmj", identity);
        const std::vector<double> positions = std::exchange(record.positions, {});
        for (std::int64_t point = 0; point < level.points; ++point) {
            record.point = point;
            record.values[0] = static_cast<double>(point);
            if (level.has_positions)
                record.trajectory = trajectories.write(positions);
            journal.append(record);
        }
    }
    costs.append = cpu_seconds() - start;
    costs.bytes = static_cast<double>(std::filesystem::file_size(journals / "rank-00000.culmj")) +
                  (level.has_positions
                       ? static_cast<double>(level.points) * sizeof(double) * samples * spheres * 3
                       : 0.0);
    start = cpu_seconds();
    archive::JournalIndex index(archive::scan_journal_folder(journals, identity));
    costs.scan = cpu_seconds() - start;
    const std::vector<double> design(static_cast<std::size_t>(2 * level.points), 1.0);
    start = cpu_seconds();
    archive::write_study_file(folder / "study.h5", description_of(level), design,
                              [&](std::int64_t point) {
                                  const double begin = cpu_seconds();
                                  auto found = index.find_record(point);
                                  costs.read += cpu_seconds() - begin;
                                  return found;
                              });
    costs.hdf5 = cpu_seconds() - start - costs.read;
    costs.study_bytes = static_cast<double>(std::filesystem::file_size(folder / "study.h5"));
    std::filesystem::remove_all(folder);
    return costs;
}

void print_table(const std::filesystem::path& folder) {
    constexpr int repeats = 5;
    fmt::print("Processor time per point on one rank, µs (the disk itself not included), least of "
               "{} repeats; {} samples, {} spheres; "
               "\"points/s\": all four together.\n\n"
               "| stored | points | kB a point | in study.h5 | journal | scan | read again | HDF5 "
               "| points/s | "
               "MB/s |\n|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|\n",
               repeats, samples, spheres);
    for (const Level& level :
         {Level{"fit", 200'000, 0, false, false}, Level{"tip", 2'000, 0, true, false},
          Level{"heights (5)", 1'000, 5, true, false}, Level{"full", 60, 0, true, true}}) {
        Costs least = measure(level, folder);
        const auto keep_least = [](double& kept, double now) { kept = std::min(kept, now); };
        for (int k = 1; k < repeats; ++k) {
            const Costs now = measure(level, folder);
            keep_least(least.append, now.append);
            keep_least(least.scan, now.scan);
            keep_least(least.read, now.read);
            keep_least(least.hdf5, now.hdf5);
        }
        const auto points = static_cast<double>(level.points);
        const double us = 1e6 / points;
        const double all = least.append + least.scan + least.read + least.hdf5;
        fmt::print("| {} | {} | {:.2f} | {:.2f} | {:.2f} | {:.2f} | {:.2f} | {:.2f} | {:.0f} | "
                   "{:.0f} |\n",
                   level.name, level.points, 1e-3 * least.bytes / points,
                   1e-3 * least.study_bytes / points, us * least.append, us * least.scan,
                   us * least.read, us * least.hdf5, points / all, 1e-6 * least.bytes / all);
    }
}

} // namespace
} // namespace culm::bench

int main(int argc, char** argv) {
    if (argc != 2) {
        std::fputs("use: bench_archive_throughput SCRATCH_FOLDER (is emptied)\n", stderr);
        return 2;
    }
    return culm::bench::run_program([folder = argv[1]] {
        culm::bench::print_table(std::filesystem::path(folder) / "archive-throughput");
    });
}
