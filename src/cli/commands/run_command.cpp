// SPDX-License-Identifier: BSD-3-Clause
// culm run STUDY.toml [-o DIR] [--resume] [--dry-run]
#include "archive/file_descriptor.hpp"
#include "cli/interruption.hpp"
#include "cli/options.hpp"
#include "cli/progress.hpp"
#include "cli/provenance.hpp"
#include "cluster/batch_system.hpp"
#include "farm/batch.hpp"
#include "farm/communicator.hpp"
#include "present/files.hpp"
#include "present/study/study.hpp"
#include "present/text.hpp"
#include "run/simulate.hpp"
#include "study/execute/execute.hpp"
#include "study/summary/summary.hpp"

#include <chrono>
#include <cstdio>
#include <numeric>
#include <optional>
#include <string>

#include <fmt/core.h>

namespace culm::cli {
namespace {

struct RunArguments {
    std::string study;
    std::string output;
    study::ResumeOptions folder;
    std::string walltime;
    std::string part;
    farm::Clock::time_point start = farm::Clock::now();
    bool dry_run = false;
    bool quiet = false;
};

std::string plan_text(const study::Study& study, const std::vector<std::int64_t>& points,
                      int ranks) {
    const auto batches = study::make_batches(study, points);
    const study::Estimate plan = study::estimate(study, batches);
    const std::size_t lanes = run::lanes_per_batch(study.config.base.integrator.method);
    const bool fills_lanes = study.config.kind == study::StudyKind::Vibration && lanes > 1;
    std::string text = fmt::format(
        "study          {}\n"
        "stem           {} (point 0)\n"
        "points         {} in {} batch{}{}\n"
        "integrator     {}\n"
        "estimated cost {:.3g} core seconds, {:.3g} s on {}\n"
        "memory         {} per rank\n"
        "archive        {} before compression\n",
        study.config.name, study::first_stem(study), plan.points, plan.batches,
        plan.batches == 1 ? "" : "es",
        fills_lanes ? fmt::format(", up to {} SIMD lanes each", lanes) : "",
        study::integrator_text(study.config), plan.core_seconds, plan.core_seconds / ranks,
        present::counted(ranks, "rank"), present::bytes_text(plan.memory_bytes_per_rank),
        present::bytes_text(plan.archive_bytes));
    if (const std::int64_t tests = study.design.tests; tests > 1)
        text += fmt::format("stems          {}, {} tests of each\n",
                            study.design.point_count() / tests, tests);
    return text;
}

/// The points to be computed, with their cost.
std::string announcement(const study::Estimate& plan, const farm::Pace& pace, int ranks) {
    const double seconds = plan.core_seconds * (pace.is_known() ? pace.mean() : 1.0);
    std::string text = fmt::format(
        "{} to compute: about {} of processor time {}", present::counted(plan.points, "point"),
        present::estimate_text(seconds),
        pace.is_known() ? "at the pace of this study's runs so far" : "on the reference machine");
    if (ranks > 1)
        text += fmt::format(", {} on {} ranks", present::estimate_text(seconds / ranks), ranks);
    return text + fmt::format("; {} on the disk before compression\n",
                              present::bytes_text(plan.archive_bytes));
}

std::string extension_text(const study::Extension& extension, const std::string& folder) {
    if (!extension.former.empty())
        return fmt::format("the study in {} has no histories at the new heights: its points are "
                           "computed again, and the former archive stays in {}",
                           folder, extension.former);
    return fmt::format("the study in {} is extended: {} of {} points are there", folder,
                       extension.kept, extension.points);
}

/// No point can be computed in this walltime. Does not return exit code 75: a script that restarts
/// itself on 75 would try the same walltime forever.
core::ExitCode report_walltime_too_short(const study::ExecuteOutcome& outcome) {
    print_error(fmt::format(
        "none of the {} can be computed in the walltime of this run; "
        "the shortest takes about {} {}; give it a longer --walltime (job limit)",
        present::counted(outcome.farm.points_total, "missing point"),
        cluster::walltime_text(outcome.shortest_batch_s),
        outcome.farm.pace.is_known() ? "at the pace so far" : "on the reference machine"));
    return core::ExitCode::BadInput;
}

core::ExitCode report_early_stop(const study::Study& study, const study::StudyFolder& folder,
                                 const study::ExecuteOutcome& outcome) {
    const std::string& failure = outcome.farm.failure;
    if (outcome.farm.out_of_time && failure.empty() && outcome.farm.lost.empty() &&
        outcome.farm.points_completed + outcome.farm.points_failed == 0)
        return report_walltime_too_short(outcome);
    if (!failure.empty())
        print_error(failure);
    for (const farm::LostBatch& lost : outcome.farm.lost)
        if (!failure.ends_with(lost.reason))
            print_error(fmt::format("rank {} lost a batch of points: {}", lost.rank, lost.reason));
    print_error(fmt::format(
        "stopped early{}; {} of {} points are computed and kept in {}. Continue with "
        "--resume.",
        outcome.farm.out_of_time ? " before the walltime ends" : "",
        outcome.resumed_points + outcome.farm.points_completed + outcome.farm.points_failed,
        study.design.point_count(), folder.path().string()));
    return core::ExitCode::StoppedEarly;
}

study::Part part_of(const std::string& text) {
    study::Part part;
    char rest = 0;
    if (!text.empty() &&
        (std::sscanf(text.c_str(), "%ld/%ld%c", &part.number, &part.count, &rest) != 2 ||
         part.number < 1 || part.number > part.count))
        throw core::InputError(
            fmt::format("--part {}: must be K/N with K from 1 to N, for example 2/4", text));
    return part;
}

/// Writes and prints the results of a reduced study; returns the command's exit code.
template <class Summary>
core::ExitCode hand_out(const study::StudyFolder& folder, const Summary& summary,
                        const std::string& table) {
    present::write_summary(folder, summary);
    const auto failed = static_cast<std::int64_t>(summary.failed.size());
    fmt::print("stem: {} (point 0)\n{}\n{} of {} points completed, computed in {:.2f} s on "
               "{}\narchive {}\nsummary {}\n",
               summary.stem, table, summary.points - failed, summary.points, summary.wall_s,
               present::counted(summary.ranks, "rank"), folder.archive().string(),
               folder.summary().string());
    return failed == 0 ? core::ExitCode::Done : core::ExitCode::PointsFailed;
}

/// After the computation, on rank 0: reduce, write, print. Returns the command's exit code.
core::ExitCode report(const study::StudyFolder& folder) {
    const study::ArchivedStudy archived = study::open_archive(folder);
    if (archived.study.config.kind == study::StudyKind::Timestep) {
        const study::TimestepSummary summary = study::reduce_timestep_study(archived);
        return hand_out(folder, summary, present::timestep_table(summary));
    }
    const study::StudySummary summary = study::reduce_study(archived, std::nullopt);
    return hand_out(folder, summary, present::regression_table(summary));
}

core::ExitCode run(const RunArguments& arguments, const farm::Communicator* communicator) {
    const bool prints = is_root(communicator);
    const int ranks = rank_count(communicator);
    const study::Study study = study::load_study(arguments.study);
    const std::string output =
        arguments.output.empty() ? "results/" + study.config.name : arguments.output;
    const study::StudyFolder folder(output);
    if (arguments.dry_run) {
        std::vector<std::int64_t> all(static_cast<std::size_t>(study.design.point_count()));
        std::iota(all.begin(), all.end(), 0);
        if (prints)
            fmt::print("{}output         {}\n", plan_text(study, all, ranks), output);
        return core::ExitCode::Done;
    }
    const std::optional<RunDeadline> deadline =
        run_deadline(arguments.walltime, arguments.start, communicator);
    if (deadline && prints && !arguments.quiet)
        fmt::print(stderr, "culm: {}\n", deadline->text);
    ProgressDisplay display(arguments.quiet || !prints);
    study::ExecuteOptions options;
    options.folder = arguments.folder;
    options.provenance = build_provenance();
    options.part = part_of(arguments.part);
    options.lock_wait = {std::chrono::seconds(30),
                         [&output] {
                             fmt::print(stderr,
                                        "culm: another process still works in {}; waiting for it, "
                                        "30 s at most\n",
                                        output);
                         },
                         has_stop_signal};
    if (!arguments.quiet)
        options.announce = [ranks](const study::Estimate& plan, const farm::Pace& pace) {
            if (plan.points > 0)
                fmt::print(stderr, "{}", announcement(plan, pace, ranks));
        };
    if (deadline)
        options.farm.deadline = deadline->time;
    options.farm.stop_requested =
        stop_after_signal(communicator, "the points computed so far", output);
    options.farm.progress = [&display](const farm::Progress& progress) { display.show(progress); };
    if (arguments.folder.resume) {
        const auto extension = farm::on_root(communicator, [&] {
            return study::extend_folder(study, folder, options.provenance, options.lock_wait);
        });
        if (extension && prints)
            print_note(extension_text(*extension, output));
    }
    const study::ExecuteOutcome outcome = study::execute(study, folder, communicator, options);
    display.finish();
    if (prints && !outcome.lost_trajectories.empty())
        print_warning(fmt::format(
            "points computed again, because their trajectories were lost: {}; the first: {}",
            outcome.lost_trajectories.size(), outcome.lost_trajectories.front()));
    return farm::on_root(communicator, [&] {
        if (!archive::FileDescriptor(output, archive::FileDescriptor::Access::Read).can_be_locked())
            print_note(
                fmt::format("the file system of {} has no locks: nothing prevents a second job "
                            "from working there at the same time",
                            output));
        const farm::Summary& done = outcome.farm;
        if (!outcome.archive_is_complete && !arguments.part.empty() &&
            done.points_completed + done.points_failed == done.points_total) {
            fmt::print("part {} is complete in {}; `culm archive merge` joins the parts\n",
                       arguments.part, output);
            return done.points_failed == 0 ? core::ExitCode::Done : core::ExitCode::PointsFailed;
        }
        if (!outcome.archive_is_complete)
            return report_early_stop(study, folder, outcome);
        const core::ExitCode exit_code = report(folder);
        fmt::print("{}", next_step("culm report" + as_words({output})));
        return exit_code;
    });
}

/// Reports a write error: the disk may be full, broken, or read-only. Every rank meets it.
core::ExitCode run_or_stop(const RunArguments& arguments, const farm::Communicator* communicator) {
    try {
        return run(arguments, communicator);
    } catch (const core::StorageError& error) {
        if (is_root(communicator))
            print_error(fmt::format("{}\nNothing computed so far is lost. Once the disk can be "
                                    "written again, continue with --resume.",
                                    error.what()));
        return core::ExitCode::StoppedEarly;
    }
}

} // namespace

void add_run_command(CLI::App& app, core::ExitCode& exit_code, int& argc, char**& argv) {
    CLI::App* command = app.add_subcommand(
        "run", "Run a study (alone, or under mpirun or srun), archive and reduce it");
    auto arguments = std::make_shared<RunArguments>();
    add_option(*command, "study", arguments->study, "STUDY.toml",
               "Study file (TOML; docs/config.md)")
        ->required();
    add_option(*command, "-o,--output", arguments->output, "DIR",
               "Folder for study.h5 and summary.json (default: results/<study name>)");
    CLI::Option* resume = command->add_flag(
        "--resume", arguments->folder.resume,
        "Compute only the points that are missing in the folder. The study may have more levels, "
        "points, replicates or stored heights than the one there; another change is refused");
    command
        ->add_flag("--retry-failed", arguments->folder.retry_failed,
                   "With --resume: compute failed points again")
        ->needs(resume);
    add_option(*command, "--crash-limit", arguments->folder.crash_limit, "N",
               "A point fails after N processes died while computing it (default 5; 0: no "
               "limit)")
        ->check(CLI::Range(0, 1'000'000));
    add_option(*command, "--walltime", arguments->walltime, "TIME",
               "End within this time (90s, 45min, HH:MM:SS, D-HH:MM:SS): start no point that "
               "would not finish by then; exit code 75 if points are missing (default: the "
               "time limit of the batch job)");
    add_option(*command, "--part", arguments->part, "K/N",
               "Compute every N-th point from the K-th on, for N jobs with a folder each; `culm "
               "archive merge` joins the folders");
    command->add_flag("--dry-run", arguments->dry_run,
                      "Check everything and print the plan: points, lanes, cost, memory, archive");
    command->add_flag("-q,--quiet", arguments->quiet, "No progress");
    command->parse_complete_callback([arguments] { // batch systems may signal while MPI starts
        if (!arguments->dry_run)
            watch_stop_signals();
    });
    run_on_ranks(*command, arguments, exit_code, argc, argv, run_or_stop);
}

} // namespace culm::cli
