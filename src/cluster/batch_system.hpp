// SPDX-License-Identifier: BSD-3-Clause
// The remaining time of a job, as the batch system reports it.
#pragma once

#include <chrono>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace culm::cluster {

/// Access to the environment and to programs; replaced in tests.
struct BatchSystemAccess {
    /// An environment variable; empty if it is not set.
    std::function<std::string(const std::string& name)> variable;
    /// Standard output of a program, run without a shell; empty if it fails or takes too long.
    std::function<std::string(const std::vector<std::string>& words)> output_of;
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

/// Runs the program named by the first word (looked up in PATH) with the others as its arguments,
/// without a shell, and returns its standard output of at most 64 kB. Empty if it cannot be
/// started, fails, or takes longer than `patience` and is ended.
[[nodiscard]] std::string program_output(const std::vector<std::string>& words,
                                         std::chrono::milliseconds patience);

} // namespace culm::cluster
