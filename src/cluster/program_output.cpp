// SPDX-License-Identifier: BSD-3-Clause
#include "cluster/program_output.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

namespace culm::cluster {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::size_t longest_output = 64 * 1024;

/// Starts the program with its standard output on `output`; -1 if it cannot be started.
::pid_t start(const std::vector<std::string>& words, int output) {
    std::vector<std::string> copies = words;
    std::vector<char*> arguments;
    for (std::string& word : copies)
        arguments.push_back(word.data());
    arguments.push_back(nullptr);
    ::posix_spawn_file_actions_t actions;
    ::posix_spawn_file_actions_init(&actions);
    ::posix_spawn_file_actions_adddup2(&actions, output, STDOUT_FILENO);
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
    if (!is_whole)
        ::kill(process, SIGKILL);
    int status = 0;
    while (::waitpid(process, &status, 0) < 0 && errno == EINTR) {
    }
    return is_whole && WIFEXITED(status) && WEXITSTATUS(status) == 0 ? text : "";
}

} // namespace culm::cluster
