// SPDX-License-Identifier: BSD-3-Clause
// Job scripts for a study or the diagnosis of a laboratory, sized by the cost of their items.
#pragma once

#include "farm/pace.hpp"
#include "study/execute/plan.hpp"

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace culm::cluster {

/// The user's request.
struct JobRequest {
    int nodes = 1;
    int ranks_per_node = 1;
    std::optional<double> walltime_s; ///< empty: the expected time of the study
};

struct JobSize {
    int nodes = 1; ///< at most the number that the work can keep busy
    int ranks = 1;
    double core_seconds = 0.0;    ///< expected for everything that is missing
    double longest_batch_s = 0.0; ///< rarely exceeded by a batch
    double compute_s = 0.0;       ///< expected on these ranks
    double walltime_s = 0.0;      ///< limit of one job, whole minutes unless the user gave it
    std::int64_t jobs = 1;        ///< jobs that the study is expected to need
    bool pace_is_learned = false; ///< else from the reference machine's times
};

/// Batches with their cost in seconds of the reference machine (study::make_batches), and the
/// known pace of this machine. Throws core::InputError if the walltime that the user gave is
/// too short for the longest batch.
[[nodiscard]] JobSize size_job(const std::vector<farm::Batch>& batches, const farm::Pace& pace,
                               const JobRequest& request);

enum class BatchSystem { Slurm, Pbs };
/// `culm run` computes points, `culm diagnose` stems.
enum class JobWork { Study, Laboratory };

/// Texts of the user are written into the script as quoted words, or refused where the batch system
/// reads them without a shell.
struct JobText {
    JobWork work = JobWork::Study;
    std::string name;                          ///< of the work
    std::vector<std::filesystem::path> inputs; ///< absolute: the study file, or recordings
    std::filesystem::path output;              ///< absolute
    std::filesystem::path culm;                ///< the program
    std::string partition; ///< Slurm's partition or PBS's queue; empty: the default one
    std::string account;   ///< empty: the default one
    int ranks_per_node = 1;
    std::int64_t items = 0;             ///< points that are missing, or stems
    double memory_bytes_per_rank = 0.0; ///< estimated
};

/// Throws core::InputError for a partition or an account with other characters than letters,
/// digits and _ . - + @ , (the batch system reads the line that contains it).
[[nodiscard]] std::string job_script(BatchSystem system, const JobText& text, const JobSize& size);

/// The sizes that the script is based on, without user text.
[[nodiscard]] std::string size_text(const JobSize& size, JobWork work, std::int64_t items);

} // namespace culm::cluster
