// SPDX-License-Identifier: BSD-3-Clause
#include "archive/study_probe.hpp"

#include "archive/study_file.hpp"

#include <cerrno>
#include <exception>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

namespace culm::archive {

namespace {

/// In the child: opens the file, without a word and without a core file, and ends.
[[noreturn]] void open_and_exit(const std::filesystem::path& path) {
    const rlimit nothing{0, 0};
    (void)::setrlimit(RLIMIT_CORE, &nothing);
    const rlimit patience{20, 20}; // s of processor time, where a sound file takes milliseconds
    (void)::setrlimit(RLIMIT_CPU, &patience);
    if (const int silence = ::open("/dev/null", O_WRONLY); silence >= 0)
        (void)::dup2(silence, STDERR_FILENO); // the C library complains of a broken heap there
    try {
        const StudyFile file(path);
    } catch (const std::exception&) {
        ::_exit(0); // refused in order: the parent will meet the same
    }
    ::_exit(0);
}

} // namespace

std::string death_while_opening(const std::filesystem::path& path) {
    const pid_t child = ::fork();
    if (child < 0)
        return {}; // no process to spare: the parent takes the risk
    if (child == 0)
        open_and_exit(path);
    int state = 0;
    pid_t ended = 0;
    do {
        ended = ::waitpid(child, &state, 0);
    } while (ended < 0 && errno == EINTR);
    if (ended != child || !WIFSIGNALED(state))
        return {};
    return fmt::format(
        "{}: damaged in a part that has no checksum: HDF5 itself dies of it, or comes "
        "to no end (signal {})",
        path.string(), WTERMSIG(state));
}

} // namespace culm::archive
