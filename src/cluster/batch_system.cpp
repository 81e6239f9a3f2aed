// SPDX-License-Identifier: BSD-3-Clause
#include "cluster/batch_system.hpp"

#include "cluster/walltime.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include <fcntl.h>
#include <fmt/core.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

namespace culm::cluster {

namespace {

using Clock = std::chrono::steady_clock;

constexpr std::size_t longest_output = 64 * 1024;

/// Starts the program with its standard output to `output`; -1 if it cannot be started.
::pid_t start(const std::vector<std::string>& words, int output) {
    std::vector<std::string> copies = words;
    std::vector<char*> arguments;
    for (std::string& word : copies)
        arguments.push_back(word.data());
    arguments.push_back(nullptr);
    ::posix_spawn_file_actions_t actions;
    ::posix_spawn_file_actions_init(&actions);
    ::posix_spawn_file_actions_adddup2(&actions, output, STDOUT_FILENO);
    // Without the user's terminal a query that asks for a password cannot wait there.
    ::posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    ::posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
    ::pid_t process = -1;
    if (::posix_spawnp(&process, arguments.front(), &actions, nullptr, arguments.data(), environ) !=
        0)
        process = -1;
    ::posix_spawn_file_actions_destroy(&actions);
    return process;
}

/// Reads to the end of the pipe; false if that takes too long or the text is too long.
bool read_all(int pipe, Clock::time_point deadline, std::string& text) {
    std::array<char, 4096> block{};
    while (text.size() < longest_output) {
        const auto left =
            std::chrono::duration_cast<std::chrono::milliseconds>(deadline - Clock::now()).count();
        ::pollfd ready{pipe, POLLIN, 0};
        if (left <= 0 || ::poll(&ready, 1, static_cast<int>(left)) == 0)
            return false;
        const ::ssize_t count = ::read(pipe, block.data(), block.size());
        if (count == 0)
            return true;
        if (count < 0 && errno != EINTR)
            return false;
        text.append(block.data(), static_cast<std::size_t>(std::max<::ssize_t>(0, count)));
    }
    return false;
}

/// Whether the text consists of digits only, like job numbers and times in seconds.
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
    // The name of the program is field 2, in parentheses, and may itself contain any character.
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

} // namespace

std::string program_output(const std::vector<std::string>& words,
                           std::chrono::milliseconds patience) {
    std::array<int, 2> ends{};
    if (words.empty() || ::pipe2(ends.data(), O_CLOEXEC) != 0)
        return "";
    const ::pid_t process = start(words, ends[1]);
    ::close(ends[1]);
    std::string text;
    const bool is_whole = process > 0 && read_all(ends[0], Clock::now() + patience, text);
    ::close(ends[0]);
    if (process <= 0)
        return "";
    // A busy controller may not answer for minutes; culm then computes without its answer.
    if (!is_whole)
        ::kill(process, SIGKILL);
    int status = 0;
    while (::waitpid(process, &status, 0) < 0 && errno == EINTR) {
    }
    return is_whole && WIFEXITED(status) && WEXITSTATUS(status) == 0 ? text : "";
}

BatchSystemAccess real_batch_system() {
    return {[](const std::string& name) {
                const char* value = std::getenv(name.c_str());
                return std::string(value == nullptr ? "" : value);
            },
            [](const std::vector<std::string>& words) {
                return program_output(words, std::chrono::seconds(10));
            },
            [] {
                const auto since_1970 = std::chrono::system_clock::now().time_since_epoch();
                return std::chrono::duration<double>(since_1970).count();
            },
            age_of_session};
}

std::optional<TimeLeft> time_left_of_job(const BatchSystemAccess& access) {
    if (auto left = slurm_time_left(access))
        return left;
    return pbs_time_left(access);
}

} // namespace culm::cluster
