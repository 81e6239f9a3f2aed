// SPDX-License-Identifier: BSD-3-Clause
// Scripts for batch systems that run a study until it is complete.
#pragma once

#include "cluster/job_size.hpp"

#include <filesystem>
#include <string>

namespace culm::cluster {

enum class BatchSystem { Slurm, Pbs };

/// Texts of the user are written into the script as quoted words, or refused where the batch system
/// reads them without a shell.
struct JobText {
    std::string study_name;
    std::filesystem::path study;  ///< absolute
    std::filesystem::path output; ///< absolute
    std::filesystem::path culm;   ///< the program
    std::string partition;        ///< Slurm's partition or PBS's queue; empty: the default one
    std::string account;          ///< empty: the default one
    int ranks_per_node = 1;
    std::int64_t points = 0; ///< that are missing
};

/// Throws core::InputError for a partition or an account with other characters than letters,
/// digits and _ . - + @ , (it stands in a line that the batch system reads).
[[nodiscard]] std::string job_script(BatchSystem system, const JobText& text, const JobSize& size);

/// What the script was sized from, one fact a line, without user text.
[[nodiscard]] std::string size_text(const JobSize& size, std::int64_t points);

} // namespace culm::cluster
