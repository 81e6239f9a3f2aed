// SPDX-License-Identifier: BSD-3-Clause
#include "cluster/job_script.hpp"

#include "cluster/batch_system.hpp"
#include "cluster/shell_word.hpp"
#include "cluster_generated/run_until_complete.hpp"
#include "core/error.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <queue>
#include <sstream>
#include <string_view>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace culm::cluster {

namespace {

/// The reference machine's times may be wrong by this factor on another one, measured ones by less.
constexpr double allowance_for_unknown_machine = 2.0;
constexpr double allowance_for_learned_pace = 1.25;
/// For starting MPI, reading stored results and writing the archive, s.
constexpr double start_and_end_s = 120.0;
constexpr double shortest_walltime_s = 300.0;
/// More ranks would wait for the start of MPI longer than they compute.
constexpr double least_work_of_a_rank_s = 10.0;
/// A rank needs 40 MB for most studies; twice the estimate, and at least this, MB.
constexpr double least_memory_mb = 200.0;

/// Cost on the rank that finishes last, with batches handed out longest first as in the farm.
double makespan(std::vector<double> costs, int ranks) {
    std::ranges::sort(costs, std::greater<>());
    // Longest first on the rank with the least load (Graham 1969), as the farm hands out batches.
    std::priority_queue<double, std::vector<double>, std::greater<>> loads(
        std::greater<>(), std::vector<double>(static_cast<std::size_t>(ranks), 0.0));
    double longest = 0.0;
    for (const double cost : costs) {
        const double load = loads.top() + cost;
        loads.pop();
        loads.push(load);
        longest = std::max(longest, load);
    }
    return longest;
}

/// How often a job of this length has to start. In each but the last a rank ends with a gap into
/// which its next batch does not fit.
std::int64_t expected_jobs(const JobSize& size) {
    const double usable = size.walltime_s - std::min(start_and_end_s, size.walltime_s / 10.0);
    if (size.compute_s <= usable)
        return 1;
    const double without_gap = std::max(size.longest_batch_s, usable - size.longest_batch_s);
    return static_cast<std::int64_t>(std::ceil(size.compute_s / without_gap));
}

bool is_letter_or_digit(char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
}

void require_directive_word(std::string_view option, std::string_view text) {
    const auto is_allowed = [](char c) {
        return is_letter_or_digit(c) ||
               std::string_view("_.-+@,").find(c) != std::string_view::npos;
    };
    // Directives are comments of the shell and cannot be quoted.
    if (text.starts_with('-') || !std::ranges::all_of(text, is_allowed))
        throw core::InputError(
            fmt::format("{}: {} is not a name that a batch system accepts; allowed are letters, "
                        "digits and _ . - + @ ,",
                        option, shell_word(text)));
}

/// A readable name, of characters that every batch system accepts in a directive. PBS requires a
/// letter in front.
std::string job_name(std::string_view study) {
    std::string name = "culm-";
    for (const char c : study.substr(0, 40))
        name += is_letter_or_digit(c) || c == '_' || c == '.' || c == '-' ? c : '_';
    return name;
}

std::string commented(const std::string& lines) {
    std::string text;
    std::istringstream in(lines);
    for (std::string line; std::getline(in, line);)
        text += fmt::format("#{}{}\n", line.empty() ? "" : " ", line);
    return text;
}

/// Memory to request for a rank, MB.
int memory_mb(const JobText& text) {
    return static_cast<int>(
        std::max(least_memory_mb, std::ceil(2.0 * text.memory_bytes_per_rank * 1e-6)));
}

std::string slurm_directives(const JobText& text, const JobSize& size) {
    std::string lines = fmt::format("#SBATCH --job-name={}\n"
                                    "#SBATCH --nodes={}\n"
                                    "#SBATCH --ntasks={}\n"
                                    "#SBATCH --ntasks-per-node={}\n"
                                    "#SBATCH --mem-per-cpu={}M\n"
                                    "#SBATCH --time={}\n",
                                    job_name(text.name), size.nodes, size.ranks,
                                    std::min(text.ranks_per_node, size.ranks), memory_mb(text),
                                    walltime_text(size.walltime_s));
    if (!text.partition.empty())
        lines += fmt::format("#SBATCH --partition={}\n", text.partition);
    if (!text.account.empty())
        lines += fmt::format("#SBATCH --account={}\n", text.account);
    // culm stops before the limit without a signal; the signal is for pre-emption and for a wrong
    // clock. B: the shell of this script receives it and passes it on.
    return lines + "#SBATCH --signal=B:USR1@120\n"
                   "#SBATCH --requeue\n"
                   "#SBATCH --open-mode=append\n"
                   "#SBATCH --output=%x-%j.log\n";
}

std::string pbs_directives(const JobText& text, const JobSize& size) {
    const int per_node = std::min(text.ranks_per_node, size.ranks);
    std::string lines =
        fmt::format("#PBS -N {}\n"
                    "#PBS -l select={}:ncpus={}:mpiprocs={}:mem={}mb\n"
                    "#PBS -l walltime={}\n",
                    job_name(text.name).substr(0, 15), size.nodes, per_node, per_node,
                    per_node * memory_mb(text), walltime_text_in_hours(size.walltime_s));
    if (!text.partition.empty())
        lines += fmt::format("#PBS -q {}\n", text.partition);
    if (!text.account.empty())
        lines += fmt::format("#PBS -A {}\n", text.account);
    return lines + "#PBS -j oe\n#PBS -r y\n";
}

} // namespace

JobSize size_job(const std::vector<farm::Batch>& batches, const farm::Pace& pace,
                 const JobRequest& request) {
    JobSize size;
    size.pace_is_learned = pace.is_known();
    std::vector<double> costs;
    for (const farm::Batch& batch : batches)
        costs.push_back(batch.cost);
    const double seconds_per_cost = pace.is_known() ? pace.mean() : 1.0;
    size.core_seconds = std::accumulate(costs.begin(), costs.end(), 0.0) * seconds_per_cost;
    const double most =
        std::min({double(batches.size()), std::ceil(size.core_seconds / least_work_of_a_rank_s),
                  double(request.nodes) * request.ranks_per_node});
    size.ranks = std::max(1, static_cast<int>(most));
    size.nodes = (size.ranks + request.ranks_per_node - 1) / request.ranks_per_node;
    size.longest_batch_s =
        costs.empty() ? 0.0 : std::ranges::max(costs) * (pace.is_known() ? pace.cautious() : 1.0);
    size.compute_s = std::max(makespan(costs, size.ranks) * seconds_per_cost, size.longest_batch_s);
    const double allowance =
        pace.is_known() ? allowance_for_learned_pace : allowance_for_unknown_machine;
    const double wanted =
        std::max(shortest_walltime_s, start_and_end_s + allowance * size.compute_s);
    size.walltime_s = request.walltime_s.value_or(60.0 * std::ceil(wanted / 60.0));
    if (size.longest_batch_s >= size.walltime_s)
        throw core::InputError(fmt::format(
            "--walltime: {} is too short: the longest points or stems take about {} ({})",
            walltime_text(size.walltime_s), walltime_text(size.longest_batch_s),
            pace.is_known() ? "at the pace of the runs so far" : "on the reference machine"));
    size.jobs = expected_jobs(size);
    return size;
}

std::string size_text(const JobSize& size, JobWork work, std::int64_t items) {
    const char* item = work == JobWork::Study ? "point" : "stem";
    return fmt::format("{} {}{} to compute, {:.3g} core seconds {}\n"
                       "{} rank{} on {} node{}: about {} of computing, no {} longer than about {}\n"
                       "jobs of {}: expected to need {}\n",
                       items, item, items == 1 ? "" : "s", size.core_seconds,
                       size.pace_is_learned
                           ? "at the pace of this study's runs so far"
                           : "on the reference machine (nothing has been timed here yet)",
                       size.ranks, size.ranks == 1 ? "" : "s", size.nodes,
                       size.nodes == 1 ? "" : "s", walltime_text(size.compute_s), item,
                       walltime_text(size.longest_batch_s), walltime_text(size.walltime_s),
                       size.jobs == 1 ? std::string("one job") : fmt::format("{} jobs", size.jobs));
}

std::string job_script(BatchSystem system, const JobText& text, const JobSize& size) {
    const bool is_slurm = system == BatchSystem::Slurm;
    require_directive_word(is_slurm ? "--partition" : "--queue", text.partition);
    require_directive_word("--account", text.account);
    const bool is_study = text.work == JobWork::Study;
    const char* const work = is_study ? "study" : "diagnosis";
    const std::string submission =
        is_slurm
            ? fmt::format("Submit with sbatch. It asks to be queued again (scontrol requeue) until "
                          "the\n{} is complete; scancel ends it; submitting it again continues "
                          "the {}.\n",
                          work, work)
            : fmt::format("Submit with qsub. It submits itself again until the {} is complete; "
                          "qdel ends it;\nsubmitting it again continues the {}.\n",
                          work, work);
    std::string script = "#!/bin/bash\n";
    script += is_slurm ? slurm_directives(text, size) : pbs_directives(text, size);
    script += "#\n" + commented("Written by `culm jobs`.\n" + submission + "\n" +
                                size_text(size, text.work, text.items));
    script += "set -u\n\n";
    std::vector<std::string> words;
    for (const std::filesystem::path& input : text.inputs)
        words.push_back(shell_word(input.string()));
    script += fmt::format("MODULES=\"\"           # for example \"gcc/12 openmpi/4.1\"\n"
                          "CULM={}\n"
                          "{}=({})\n"
                          "OUTPUT={}\n"
                          "LAUNCHER=(mpirun)     # or (srun --mpi=pmix)\n",
                          shell_word(text.culm.string()), is_study ? "STUDY" : "MEASUREMENTS",
                          fmt::join(words, " "), shell_word(text.output.string()));
    if (!is_study)
        script += "OPTIONS=()            # of culm diagnose, for example (--known gravity)\n";
    script += is_slurm ? "WALLTIME_S=0          # 0: culm asks Slurm for the time that is left\n"
                       : fmt::format("WALLTIME_S={}          # the limit above, s\n",
                                     static_cast<long long>(size.walltime_s));
    script += "\n# shellcheck disable=SC2086 # module takes several words\n"
              "[[ -z $MODULES ]] || module load $MODULES\n";
    if (!is_slurm)
        script += "cd \"$PBS_O_WORKDIR\" || exit 2\n";
    script += "\n";
    script += run_until_complete;
    script += "\nrun_until_complete \"$WALLTIME_S\" \\\n"
              "    \"${LAUNCHER[@]}\" \"$CULM\" ";
    script += is_study ? "run \"${STUDY[@]}\" -o \"$OUTPUT\" --resume\n"
                       : "diagnose \"${MEASUREMENTS[@]}\" -o \"$OUTPUT\" --resume --quiet \\\n"
                         "    \"${OPTIONS[@]}\"\n";
    return script;
}

} // namespace culm::cluster
