// SPDX-License-Identifier: BSD-3-Clause
// The cost of a study of very many points in addition to its computation: plan, resume, archive,
// verify, merge, reduce. The points themselves cost nothing. One process; processor and wall time.
#include "bench/cpu_time.hpp"
#include "bench/farm_synthetic.hpp"
#include "bench/run_program.hpp"
#include "study/execute/execute.hpp"
#include "study/execute/folder_state.hpp"
#include "study/execute/point_results.hpp"
#include "study/summary/summary.hpp"

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>

#include <fmt/core.h>

namespace culm::bench {
namespace {

namespace fs = std::filesystem;

/// Runs `work` and prints its time and memory.
template <class Work>
auto timed(const char* what, Work work) {
    const double wall = wall_seconds();
    const double cpu = cpu_seconds();
    auto result = work();
    fmt::print("| {} | {:.2f} | {:.2f} | {:.0f} |\n", what, cpu_seconds() - cpu,
               wall_seconds() - wall, largest_resident_megabytes());
    std::fflush(stdout);
    return result;
}

std::string population_text(std::int64_t points) {
    return fmt::format(
        "[study]\nname = \"large\"\nstore = \"fit\"\n[factors]\n"
        "length_mm = {{ distribution = \"normal\", mean = 156, sd = 4.5, min = 140, max = 172 }}\n"
        "bond_diameter_mm = {{ distribution = \"normal\", mean = 2.57, sd = 0.45, min = 1.2, max = "
        "4 }}\n"
        "bond_youngs_modulus_gpa = {{ distribution = \"lognormal\", mean = 4, sd = 2 }}\n"
        "bond_damping = {{ distribution = \"normal\", mean = 123, sd = 44, min = 10, max = 250 }}\n"
        "[design]\ntype = \"sobol\"\nscrambling = \"owen\"\npoints = {}\n",
        points);
}

/// A record with the point's own numbers in all columns, so that fits exist and differ.
archive::PointRecord numbered_record(const run::CaseSpec& spec, std::size_t columns) {
    archive::PointRecord record = trivial_record(spec, columns);
    for (double& value : record.values)
        value = spec.stem.bond_damping * spec.stem.bond_outer_diameter;
    return record;
}

/// Computes until the given number of points is done (0: all of them).
study::ExecuteOutcome run_points(const study::Study& study, const study::StudyFolder& folder,
                                 std::int64_t most) {
    study::ExecuteOptions options;
    options.folder.resume = true;
    const std::size_t columns = study::result_columns(study.config).size();
    std::int64_t done = 0;
    options.compute_point = [&](const run::CaseSpec& spec) {
        ++done;
        return numbered_record(spec, columns);
    };
    if (most > 0)
        options.farm.stop_requested = [&] { return done >= most; };
    return study::execute(study, folder, nullptr, options);
}

void print_sizes(const study::Study& study, const study::StudyFolder& folder) {
    const auto points = static_cast<double>(study.design.point_count());
    const double bytes = static_cast<double>(fs::file_size(folder.archive())) / points;
    const double data = 8.0 * static_cast<double>(study.design.factors.size() +
                                                  study::result_columns(study.config).size());
    fmt::print("\n{:.1f} bytes a point in the study file; factors and results are {:.0f} bytes "
               "before compression\n",
               bytes, data);
}

void measure(std::int64_t points, const fs::path& scratch) {
    const study::StudyFolder folder(scratch / "large");
    const study::StudyFolder copy(scratch / "merged");
    for (const auto* place : {&folder, &copy})
        fs::remove_all(place->path());
    fmt::print("{} points\n\n| what | processor, s | wall, s | largest resident set so far, MB |\n"
               "|---|---:|---:|---:|\n",
               points);
    const study::Study study = timed("design, checked at every point", [&] {
        return study::parse_study(population_text(points), "large.toml");
    });
    timed("batches, by expected cost", [&] {
        std::vector<std::int64_t> all(static_cast<std::size_t>(points));
        for (std::size_t k = 0; k < all.size(); ++k)
            all[k] = static_cast<std::int64_t>(k);
        return study::make_batches(study, all).size();
    });
    timed("first half of the points, to the journal",
          [&] { return run_points(study, folder, points / 2).farm.points_completed; });
    timed("resume: what the journals hold, every checksum", [&] {
        study::ResumeOptions options;
        options.resume = true;
        return study::prepare_folder(folder, study.config.identity(), points, options)
            .pending_points.size();
    });
    const study::ExecuteOutcome outcome =
        timed("resume, second half, study file", [&] { return run_points(study, folder, 0); });
    if (!outcome.archive_is_complete)
        throw core::StorageError("the study is not complete");
    timed("open the archive", [&] { return archive::StudyFile(folder.archive()).point_count(); });
    timed("verify the archive, every checksum",
          [&] { return archive::verify(folder.archive()).is_whole(); });
    timed("merge into another archive",
          [&] { return study::merge_folders({folder}, copy, {}).completed; });
    const study::ArchivedStudy archived =
        timed("open the archive with its design", [&] { return study::open_archive(folder); });
    timed("regressions, spread, shares of the variance",
          [&] { return study::reduce_study(archived, std::nullopt).completed; });
    print_sizes(study, folder);
}

} // namespace
} // namespace culm::bench

int main(int argc, char** argv) {
    if (argc != 3) {
        std::fputs("use: bench_large_study POINTS SCRATCH_FOLDER\n", stderr);
        return 2;
    }
    return culm::bench::run_program([&] { culm::bench::measure(std::atoll(argv[1]), argv[2]); });
}
