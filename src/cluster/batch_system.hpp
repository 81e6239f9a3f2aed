// SPDX-License-Identifier: BSD-3-Clause
// What the batch system says of the time that a job has left.
#pragma once

#include <chrono>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace culm::cluster {

/// How the world outside is asked; replaced in tests.
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
    std::string source; ///< where that comes from, for people
};

/// Time left of the job that this process belongs to. Slurm: SLURM_JOB_END_TIME, which newer
/// versions set, else squeue is asked, once. PBS: PBS_WALLTIME, counted from the start of the job's
/// shell. Nothing outside of a job, or if the job has no limit or the batch system no answer.
[[nodiscard]] std::optional<TimeLeft> time_left_of_job(const BatchSystemAccess& access);

/// Runs the program named by the first word (looked up in PATH) with the others as its arguments,
/// without a shell, and returns its standard output of at most 64 kB. Empty if it cannot be
/// started, fails, or takes longer than `patience`; it is ended then.
[[nodiscard]] std::string program_output(const std::vector<std::string>& words,
                                         std::chrono::milliseconds patience);

} // namespace culm::cluster
