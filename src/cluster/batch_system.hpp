// SPDX-License-Identifier: BSD-3-Clause
// The remaining time of a job, as the batch system reports it, durations as batch systems and
// people write them, and commands of the shell.
#pragma once

#include <chrono>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace culm::cluster {

/// Access to the environment and to programs; replaced in tests.
struct BatchSystemAccess {
    /// An environment variable; empty if it is not set.
    std::function<std::string(const std::string& name)> variable;
    /// Standard output of a shell command; empty if it fails or takes too long.
    std::function<std::string(const std::string& command)> output_of;
    std::function<double()> now;         ///< s since 1970
    std::function<double()> session_age; ///< of this process's session, s; PBS: of the job's shell
};
[[nodiscard]] BatchSystemAccess real_batch_system();

struct TimeLeft {
    double seconds = 0.0;
    std::string source; ///< origin of the number, for messages
};

/// Time left of the job that this process belongs to. Slurm: SLURM_JOB_END_TIME, which newer
/// versions set, else squeue is asked, once. PBS: PBS_WALLTIME, counted from the start of the job's
/// shell. Empty outside of a job, without a limit of the job, or without an answer.
[[nodiscard]] std::optional<TimeLeft> time_left_of_job(const BatchSystemAccess& access);

/// Runs a command of the shell and returns its standard output, less than 64 kB. Empty if it cannot
/// be started, fails, or takes longer than `patience` and is ended.
[[nodiscard]] std::string program_output(const std::string& command,
                                         std::chrono::milliseconds patience);

/// A word that a POSIX shell reads as exactly `text`, which has no zero byte.
[[nodiscard]] std::string shell_word(std::string_view text);

/// Seconds of a duration: HH:MM:SS, MM:SS, D-HH, D-HH:MM, D-HH:MM:SS, or a number with its unit,
/// 90s, 45min, 12h, 2d. A number alone is refused, because
/// Slurm reads it as minutes and PBS as seconds. Throws core::InputError, with a text that begins
/// with `what`, for any other form and for a duration that is not above zero.
[[nodiscard]] double parse_walltime(std::string_view what, const std::string& text);

/// Seconds left of a job as squeue prints them (TimeLeft); empty for UNLIMITED, INVALID, NOT_SET.
[[nodiscard]] std::optional<double> parse_time_left(std::string_view text);

/// HH:MM:SS, with days in front for a day and more (Slurm's form).
[[nodiscard]] std::string walltime_text(double seconds);

} // namespace culm::cluster
