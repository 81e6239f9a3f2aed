// SPDX-License-Identifier: BSD-3-Clause
// culm jobs slurm|pbs STUDY.toml|MEASUREMENT... --nodes N
#include "cli/options.hpp"
#include "cli/provenance.hpp"
#include "cli/recordings.hpp"
#include "cluster/batch_system.hpp"
#include "cluster/job_script.hpp"
#include "core/error.hpp"
#include "core/user_files.hpp"
#include "measure/folder/measurement_folder.hpp"
#include "study/execute/folder_state.hpp"
#include "study/execute/journal_notes.hpp"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

#include <fmt/core.h>

namespace culm::cli {
namespace {

namespace fs = std::filesystem;

struct JobsArguments {
    std::vector<std::string> inputs; ///< a study file, or folders of recordings
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

/// The work of a job.
struct Work {
    cluster::JobText text; ///< without the user's partition and account
    std::vector<farm::Batch> batches;
    farm::Pace pace;
};

fs::path output_of(const JobsArguments& arguments, const std::string& name) {
    return arguments.study_output.empty() ? "results/" + name : arguments.study_output;
}

Work study_work(const JobsArguments& arguments) {
    Work work;
    const study::Study study = study::load_study(arguments.inputs.front());
    work.text.name = study.config.name;
    work.text.output = output_of(arguments, work.text.name);
    const study::StudyFolder folder(work.text.output);
    const std::vector<std::int64_t> points = missing_points(study, folder);
    if (points.empty())
        throw core::InputError(fmt::format("{}: the study is complete; there is nothing to compute",
                                           work.text.output.string()));
    work.text.items = static_cast<std::int64_t>(points.size());
    work.batches = study::make_batches(study, points);
    work.text.memory_bytes_per_rank = study::estimate(study, work.batches).memory_bytes_per_rank;
    work.pace = study::read_pace(folder);
    return work;
}

Work laboratory_work(const JobsArguments& arguments) {
    Work work;
    const measure::MeasurementSet read = measure::read_measurements(arguments.inputs);
    const std::vector<diagnose::Specimen> specimens = diagnose::specimens_of(read.measurements);
    work.text.work = cluster::JobWork::Laboratory;
    work.text.name = fs::absolute(arguments.inputs.front()).lexically_normal().filename().string();
    work.text.output = output_of(arguments, work.text.name + "-diagnosis");
    work.text.items = static_cast<std::int64_t>(specimens.size());
    work.text.memory_bytes_per_rank = laboratory_memory(specimens.size());
    for (const double seconds :
         expected_seconds(specimens, {}, fit::candidate_effects(read.measurements).size()))
        work.batches.push_back({{static_cast<std::int64_t>(work.batches.size())}, seconds});
    return work;
}

void write_script(cluster::BatchSystem system, const JobsArguments& arguments) {
    Work work = arguments.inputs.front().ends_with(".toml") ? study_work(arguments)
                                                            : laboratory_work(arguments);
    cluster::JobText& text = work.text;
    cluster::JobRequest request{arguments.nodes, arguments.ranks_per_node, std::nullopt};
    if (request.ranks_per_node == 0)
        request.ranks_per_node =
            static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
    if (!arguments.walltime.empty())
        request.walltime_s = cluster::parse_walltime("--walltime", arguments.walltime);
    const cluster::JobSize size = cluster::size_job(work.batches, work.pace, request);
    for (const std::string& input : arguments.inputs)
        text.inputs.push_back(fs::absolute(input).lexically_normal());
    text.output = fs::absolute(text.output).lexically_normal();
    const fs::path program = own_program();
    text.culm = program.empty() ? "culm" : program;
    text.partition = arguments.partition;
    text.account = arguments.account;
    text.ranks_per_node = request.ranks_per_node;
    const std::string script = cluster::job_script(system, text, size);
    fmt::print(stderr, "{}", cluster::size_text(size, text.work, text.items));
    if (size.ranks < arguments.nodes * request.ranks_per_node)
        fmt::print(stderr, "{} ranks were asked for; there is work for {} at a time\n",
                   arguments.nodes * request.ranks_per_node, size.ranks);
    if (arguments.script.empty())
        fmt::print("{}", script);
    else
        core::write_text(arguments.script, script);
}

void add_system(CLI::App& jobs, cluster::BatchSystem system, const char* name,
                const char* description) {
    const bool is_slurm = system == cluster::BatchSystem::Slurm;
    CLI::App* command = jobs.add_subcommand(name, description);
    auto arguments = std::make_shared<JobsArguments>();
    add_option(*command, "work", arguments->inputs, "STUDY.toml | MEASUREMENT...",
               "Study file (TOML; docs/config.md), or the recordings of a laboratory "
               "(docs/laboratory.md)")
        ->required();
    add_option(*command, "--nodes", arguments->nodes, "N", "Nodes at most")
        ->required()
        ->check(CLI::Range(1, 100'000));
    add_option(*command, "--ranks-per-node", arguments->ranks_per_node, "R",
               "Processes on each node (default: the processors of this machine)")
        ->check(CLI::Range(1, 10'000));
    add_option(*command, "--walltime", arguments->walltime, "TIME",
               "Time limit of one job, 12h or HH:MM:SS (default: what the work is expected "
               "to take, with an allowance)");
    add_option(*command, is_slurm ? "--partition" : "--queue", arguments->partition, "NAME",
               is_slurm ? "Partition to run in (default: Slurm's own)"
                        : "Queue to wait in (default: PBS's own)");
    add_option(*command, "--account", arguments->account, "NAME", "Account to be charged");
    add_option(*command, "--study-output", arguments->study_output, "DIR",
               "Folder of the results (default: results/<study name>, of a laboratory "
               "results/<its folder>-diagnosis)");
    add_option(*command, "-o,--output", arguments->script, "FILE",
               "Script to write (default: the screen)");
    command->callback([arguments, system] { write_script(system, *arguments); });
}

} // namespace

void add_jobs_command(CLI::App& app) {
    CLI::App* jobs = app.add_subcommand(
        "jobs",
        "Write a job script for a cluster that runs a study, or the diagnosis of a laboratory, "
        "until it is complete");
    jobs->require_subcommand(1);
    add_system(*jobs, cluster::BatchSystem::Slurm, "slurm", "A script for sbatch");
    add_system(*jobs, cluster::BatchSystem::Pbs, "pbs", "A script for qsub (OpenPBS, PBS Pro)");
}

} // namespace culm::cli
