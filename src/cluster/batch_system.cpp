// SPDX-License-Identifier: BSD-3-Clause
#include "cluster/batch_system.hpp"

#include "cluster/program_output.hpp"
#include "cluster/walltime.hpp"

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <fstream>
#include <sstream>

#include <fmt/core.h>
#include <unistd.h>

namespace culm::cluster {
namespace {

/// Text that is a number of digits alone, as job numbers and times in seconds are.
bool is_number(const std::string& text) {
    return !text.empty() && text.size() <= 18 &&
           std::ranges::all_of(text, [](char c) { return c >= '0' && c <= '9'; });
}

std::optional<TimeLeft> slurm_time_left(const BatchSystemAccess& access) {
    const std::string job = access.variable("SLURM_JOB_ID");
    if (!is_number(job))
        return std::nullopt;
    if (const std::string end = access.variable("SLURM_JOB_END_TIME"); is_number(end))
        return TimeLeft{std::stod(end) - access.now(), "SLURM_JOB_END_TIME"};
    const std::string answer =
        access.output_of({"squeue", "--noheader", "--jobs=" + job, "--Format=TimeLeft"});
    const std::optional<double> left = parse_time_left(answer);
    return left ? std::optional(TimeLeft{*left, "squeue, job " + job}) : std::nullopt;
}

std::optional<TimeLeft> pbs_time_left(const BatchSystemAccess& access) {
    const std::string limit = access.variable("PBS_WALLTIME");
    if (access.variable("PBS_JOBID").empty() || !is_number(limit))
        return std::nullopt;
    return TimeLeft{std::stod(limit) - access.session_age(), "PBS_WALLTIME"};
}

/// Field 22 of /proc/PID/stat: ticks from the start of the machine to that of the process.
double start_ticks(::pid_t process) {
    std::ifstream in(fmt::format("/proc/{}/stat", process));
    std::string text;
    std::getline(in, text);
    std::istringstream fields(text.substr(std::min(text.size(), text.rfind(')') + 1)));
    std::string field;
    for (int k = 3; k <= 22; ++k)
        if (!(fields >> field))
            return 0.0;
    return std::strtod(field.c_str(), nullptr);
}

double age_of_session() {
    double uptime = 0.0;
    std::ifstream("/proc/uptime") >> uptime;
    const double start = start_ticks(::getsid(0));
    const double ticks_per_second = static_cast<double>(::sysconf(_SC_CLK_TCK));
    return start > 0.0 ? std::max(0.0, uptime - start / ticks_per_second) : 0.0;
}

double seconds_since_1970() {
    return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch())
        .count();
}

} // namespace

BatchSystemAccess real_batch_system() {
    return {[](const std::string& name) {
                const char* value = std::getenv(name.c_str());
                return std::string(value == nullptr ? "" : value);
            },
            [](const std::vector<std::string>& words) {
                return program_output(words, std::chrono::seconds(10));
            },
            seconds_since_1970, age_of_session};
}

std::optional<TimeLeft> time_left_of_job(const BatchSystemAccess& access) {
    if (auto left = slurm_time_left(access))
        return left;
    return pbs_time_left(access);
}

} // namespace culm::cluster
