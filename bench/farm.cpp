// SPDX-License-Identifier: BSD-3-Clause
// The cost of the farm and the archive: efficiency on two ranks, share of HDF5, points per second.
// Runs with mpirun -n 2; bench/farm.sh starts it.
#include "bench/cpu_time.hpp"
#include "bench/farm_synthetic.hpp"
#include "bench/run_program.hpp"
#include "farm/batch.hpp"
#include "farm/environment.hpp"
#include "study/execute/execute.hpp"
#include "study/execute/point_results.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include <fmt/core.h>
#include <unistd.h>

namespace culm::bench {
namespace {

/// One measured run, on one rank or on all.
struct Run {
    double wall = 0.0;     ///< s, of everything between the start and the end of the study
    double busy = 0.0;     ///< share of the ranks' time in the map that went into work functions
    double outside = 0.0;  ///< share of the wall time outside the map, when one rank works
    double storage = 0.0;  ///< s, of journals and trajectories, on this rank
    double assembly = 0.0; ///< s
};

using Task = std::function<Run(const farm::Communicator* communicator)>;

/// On rank 0; elsewhere unspecified.
double mean_over_ranks(const farm::Communicator& communicator, double value) {
    double sum = 0.0;
    for (const std::string& text : communicator.gather(fmt::format("{:.17g}", value)))
        sum += std::stod(text);
    return sum / communicator.size();
}

/// Wall time of the whole task on every rank at once, without a message between them: the mean over
/// the ranks, in s, on rank 0.
double run_apart(const farm::Communicator& communicator, const Task& task) {
    communicator.barrier();
    return mean_over_ranks(communicator, task(nullptr).wall);
}

/// Compares one job of all ranks with ranks that do the whole work each. Both keep all cores busy,
/// so that what the machine loses when its cores work together cancels: on a shared machine the
/// ratio to one rank alone varied between 95 and 106 %. The two follow each other, in changing
/// order, and the median of the rounds' ratios lies between the least and the largest with a
/// probability of 1 − 2^(1 − rounds).
void compare_ranks(const farm::Communicator& communicator, const char* name, const Task& task) {
    constexpr int rounds = 5;
    constexpr double target = 0.97;
    Timings independent;
    Timings efficiency;
    Timings busy;
    Timings outside;
    for (int round = 0; round < rounds; ++round) {
        double apart = round % 2 == 0 ? run_apart(communicator, task) : 0.0;
        communicator.barrier();
        const Run together = task(&communicator);
        if (round % 2 != 0)
            apart = run_apart(communicator, task);
        independent.seconds.push_back(apart);
        efficiency.seconds.push_back(apart / together.wall / communicator.size());
        busy.seconds.push_back(together.busy);
        outside.seconds.push_back(together.outside);
    }
    if (communicator.rank() != 0)
        return;
    const auto [least, largest] = std::ranges::minmax(efficiency.seconds);
    fmt::print("| {} | {:.1f} | {:.1f} % ({:.1f} to {:.1f}) | {} | {:.1f} % | {:.1f} % |\n", name,
               independent.median(), 100.0 * efficiency.median(), 100.0 * least, 100.0 * largest,
               least >= target    ? "met"
               : largest < target ? "missed"
                                  : "not decided by this measurement",
               100.0 * busy.median(), 100.0 * outside.median());
}

Run measured(const farm::Summary& summary, double start) {
    Run run;
    run.wall = wall_seconds() - start;
    run.busy = summary.work_s / (summary.elapsed_s * summary.ranks);
    run.outside = 1.0 - summary.elapsed_s / run.wall;
    return run;
}

/// Work of known processor time, which shows the loss of the farm itself.
Run synthetic(const farm::Communicator* communicator) {
    const SyntheticWork work = synthetic_work();
    const double start = wall_seconds();
    const auto spin = [&work](const farm::Batch& batch, farm::Heartbeat& heartbeat) {
        const double begin = wall_seconds();
        const double end = cpu_seconds() + work.seconds[static_cast<std::size_t>(batch.points[0])];
        while (cpu_seconds() < end)
            heartbeat.beat();
        return farm::BatchReport{1, 0, wall_seconds() - begin};
    };
    return measured(communicator == nullptr ? farm::Farm().map(work.batches, spin)
                                            : farm::Farm(*communicator).map(work.batches, spin),
                    start);
}

Run real_study(const farm::Communicator* communicator, const std::filesystem::path& scratch,
               const std::string& text) {
    const study::Study study = study::parse_study(text, "bench.toml");
    const study::StudyFolder folder(
        scratch / (communicator == nullptr ? fmt::format("study-{}", ::getpid()) : "study"));
    if (communicator == nullptr || communicator->rank() == 0)
        std::filesystem::remove_all(folder.path());
    if (communicator != nullptr)
        communicator->barrier();
    const double start = wall_seconds();
    const study::ExecuteOutcome outcome = study::execute(study, folder, communicator, {});
    if (!outcome.archive_is_complete)
        throw farm::FarmError("the study was not completed");
    Run run = measured(outcome.farm, start);
    run.storage = outcome.storage_s;
    run.assembly = outcome.assembly_s;
    return run;
}

/// The ranks time a point differently; they must run the same study.
std::string agreed_study_text(const farm::Communicator& communicator, const std::string& store,
                              double seconds) {
    return communicator.broadcast(communicator.rank() == 0 ? study_text(store, seconds) : "");
}

void print_efficiency(const farm::Communicator& communicator,
                      const std::filesystem::path& scratch) {
    if (communicator.rank() == 0)
        fmt::print(
            "\n## Efficiency of {} ranks\n\n| work | independent ranks, s | efficiency | 97 % | "
            "busy | outside the map |\n|---|---:|---:|---|---:|---:|\n",
            communicator.size());
    compare_ranks(communicator, "synthetic, 1000 batches of 20 ms on average", &synthetic);
    const std::string text = agreed_study_text(communicator, "tip", 20.0);
    compare_ranks(communicator, "simulations, `tip`", [&](const farm::Communicator* ranks) {
        return real_study(ranks, scratch, text);
    });
}

void print_shares(const farm::Communicator& communicator, const std::filesystem::path& scratch) {
    const bool is_root = communicator.rank() == 0;
    if (is_root)
        fmt::print("\n## Share of the archive in the wall time of a study, {} ranks\n\n| stored | "
                   "wall, s | journals and trajectories, s | study file, s | share |\n"
                   "|---|---:|---:|---:|---:|\n",
                   communicator.size());
    for (const char* store : {"fit", "tip", "heights", "full"}) {
        const Run run =
            real_study(&communicator, scratch, agreed_study_text(communicator, store, 20.0));
        const double storage = mean_over_ranks(communicator, run.storage);
        if (is_root)
            fmt::print("| {} | {:.2f} | {:.3f} | {:.3f} | {:.2f} % |\n", store, run.wall, storage,
                       run.assembly, 100.0 * (storage + run.assembly) / run.wall);
    }
}

constexpr std::int64_t points = 1'000'000; ///< that cost nothing

void print_scheduler_rate(const farm::Communicator& communicator) {
    const std::vector<farm::Batch> batches = trivial_batches(points);
    const auto nothing = [](const farm::Batch& batch, farm::Heartbeat&) {
        return farm::BatchReport{static_cast<std::int64_t>(batch.points.size()), 0, 0.0};
    };
    farm::Farm farm(communicator);
    const farm::Summary in_ranges = farm.map(batches, nothing);
    farm::FarmOptions one_by_one;
    one_by_one.chunk_seconds = 0.0;
    const farm::Summary single =
        farm.map(std::span(batches).first(points / 10), nothing, one_by_one);
    if (communicator.rank() == 0)
        fmt::print("\n## Trivial points, {} ranks\n\n"
                   "* through the scheduler: {:.0f} points/s\n"
                   "* through the scheduler, one by one: {:.0f} points/s\n",
                   communicator.size(), static_cast<double>(points) / in_ranges.elapsed_s,
                   static_cast<double>(points) / 10.0 / single.elapsed_s);
}

void print_archive_rate(const farm::Communicator& communicator,
                        const std::filesystem::path& scratch) {
    const bool is_root = communicator.rank() == 0;
    const study::Study study = study::parse_study(trivial_study_text(points), "trivial.toml");
    const study::StudyFolder folder(scratch / "trivial");
    if (is_root)
        std::filesystem::remove_all(folder.path());
    communicator.barrier();
    study::ExecuteOptions options;
    const std::size_t columns = study::result_columns(study.config).size();
    options.compute_point = [columns](const run::CaseSpec& spec) {
        return trivial_record(spec, columns);
    };
    const double start = wall_seconds();
    const study::ExecuteOutcome outcome = study::execute(study, folder, &communicator, options);
    const double wall = wall_seconds() - start;
    const std::vector<std::string> memory =
        communicator.gather(fmt::format("{:.0f}", largest_resident_megabytes()));
    if (is_root)
        fmt::print("* to the archive (journal, then HDF5): {} points in {:.2f} s, {:.0f} points/s; "
                   "map {:.2f} s, study file {:.2f} s; largest resident set {} MB\n",
                   points, wall, static_cast<double>(points) / wall, outcome.farm.elapsed_s,
                   outcome.assembly_s, fmt::join(memory, ", "));
}

void measure(int argc, char** argv) {
    const farm::Environment environment(argc, argv);
    const farm::Communicator communicator = environment.world();
    const std::string what = argv[1];
    const std::filesystem::path scratch = argv[2];
    if (what == "scheduler")
        print_scheduler_rate(communicator);
    else if (what == "archive")
        print_archive_rate(communicator, scratch);
    else if (what == "shares")
        print_shares(communicator, scratch);
    else
        print_efficiency(communicator, scratch);
}

} // namespace
} // namespace culm::bench

int main(int argc, char** argv) {
    if (argc != 3) {
        std::fputs(
            "use: mpirun -n 2 bench_farm scheduler|archive|shares|efficiency SCRATCH_FOLDER\n",
            stderr);
        return 2;
    }
    return culm::bench::run_program([&] { culm::bench::measure(argc, argv); });
}
