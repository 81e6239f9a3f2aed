// SPDX-License-Identifier: BSD-3-Clause
// culm jobs slurm|pbs STUDY.toml --nodes N
#include "cli/command_line.hpp"
#include "cli/commands.hpp"
#include "cli/provenance.hpp"
#include "cluster/batch_system.hpp"
#include "cluster/job_script.hpp"
#include "core/error.hpp"
#include "present/files.hpp"
#include "study/execute/folder_state.hpp"
#include "study/execute/journal_notes.hpp"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/core.h>

namespace culm::cli {
namespace {

namespace fs = std::filesystem;

struct JobsArguments {
    std::string study;
    std::string study_output;
    std::string script;
    std::string walltime;
    std::string partition;
    std::string account;
    int nodes = 1;
    int ranks_per_node = 0;
};

/// The points that a run with --resume would compute.
std::vector<std::int64_t> missing_points(const study::Study& study,
                                         const study::StudyFolder& folder) {
    std::vector<std::int64_t> missing;
    const bool has_begun = study::is_there(folder.archive()) || study::is_there(folder.journals());
    std::optional<std::vector<archive::PointStatus>> known;
    if (has_begun) {
        const auto state = study::read_folder_state(folder, study::FolderDepth::Glance);
        if (!state.identity.empty() && state.identity != study.config.identity())
            throw core::InputError(
                fmt::format("{} holds another study; choose another folder with --study-output",
                            folder.path().string()));
        known = state.points;
    }
    for (std::int64_t point = 0; point < study.design.point_count(); ++point)
        if (!known || (*known)[static_cast<std::size_t>(point)] == archive::PointStatus::Missing)
            missing.push_back(point);
    return missing;
}

void write_script(cluster::BatchSystem system, const JobsArguments& arguments) {
    const study::Study study = study::load_study(arguments.study);
    const fs::path output =
        arguments.study_output.empty() ? "results/" + study.config.name : arguments.study_output;
    const study::StudyFolder folder(output);
    const std::vector<std::int64_t> points = missing_points(study, folder);
    if (points.empty())
        throw core::InputError(
            fmt::format("{}: the study is complete; there is nothing to compute", output.string()));
    cluster::JobRequest request{arguments.nodes, arguments.ranks_per_node, std::nullopt};
    if (request.ranks_per_node == 0)
        request.ranks_per_node =
            static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
    if (!arguments.walltime.empty())
        request.walltime_s = cluster::parse_walltime("--walltime", arguments.walltime);
    const std::vector<farm::Batch> batches = study::make_batches(study, points);
    const cluster::JobSize size = cluster::size_job(batches, study::read_pace(folder), request);
    const fs::path program = own_program();
    const std::string script = cluster::job_script(
        system,
        {study.config.name, fs::absolute(arguments.study).lexically_normal(),
         fs::absolute(output).lexically_normal(), program.empty() ? "culm" : program,
         arguments.partition, arguments.account, request.ranks_per_node,
         static_cast<std::int64_t>(points.size()),
         study::estimate(study, batches).memory_bytes_per_rank},
        size);
    fmt::print(stderr, "{}", cluster::size_text(size, static_cast<std::int64_t>(points.size())));
    if (size.ranks < arguments.nodes * request.ranks_per_node)
        fmt::print(stderr, "{} ranks were asked for; the study has work for {} at a time\n",
                   arguments.nodes * request.ranks_per_node, size.ranks);
    if (arguments.script.empty())
        fmt::print("{}", script);
    else
        present::write_text(arguments.script, script);
}

void add_system(CLI::App& jobs, cluster::BatchSystem system, const char* name,
                const char* description) {
    const bool is_slurm = system == cluster::BatchSystem::Slurm;
    CLI::App* command = jobs.add_subcommand(name, description);
    auto arguments = std::make_shared<JobsArguments>();
    add_option(*command, "study", arguments->study, "STUDY.toml",
               "Study file (TOML; docs/config.md)")
        ->required();
    add_option(*command, "--nodes", arguments->nodes, "N", "Nodes at most")
        ->required()
        ->check(CLI::Range(1, 100'000));
    add_option(*command, "--ranks-per-node", arguments->ranks_per_node, "R",
               "Processes on each node (default: the processors of this machine)")
        ->check(CLI::Range(1, 10'000));
    add_option(*command, "--walltime", arguments->walltime, "TIME",
               "Time limit of one job, 12h or HH:MM:SS (default: what the study is expected "
               "to take, with an allowance)");
    add_option(*command, is_slurm ? "--partition" : "--queue", arguments->partition, "NAME",
               is_slurm ? "Partition to run in (default: Slurm's own)"
                        : "Queue to wait in (default: PBS's own)");
    add_option(*command, "--account", arguments->account, "NAME", "Account to be charged");
    add_option(*command, "--study-output", arguments->study_output, "DIR",
               "Folder of the study (default: results/<study name>)");
    add_option(*command, "-o,--output", arguments->script, "FILE",
               "Script to write (default: the screen)");
    command->callback([arguments, system] { write_script(system, *arguments); });
}

} // namespace

void add_jobs_command(CLI::App& app) {
    CLI::App* jobs = app.add_subcommand(
        "jobs", "Write a job script for a cluster that runs a study until it is complete");
    jobs->require_subcommand(1);
    add_system(*jobs, cluster::BatchSystem::Slurm, "slurm", "A script for sbatch");
    add_system(*jobs, cluster::BatchSystem::Pbs, "pbs", "A script for qsub (OpenPBS, PBS Pro)");
}

} // namespace culm::cli
