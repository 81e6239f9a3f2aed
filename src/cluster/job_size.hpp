// SPDX-License-Identifier: BSD-3-Clause
// How many processes and how much time a study is worth, from the cost model.
#pragma once

#include "farm/pace.hpp"
#include "study/plan.hpp"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace culm::cluster {

/// What the user asks for.
struct JobRequest {
    int nodes = 1;
    int ranks_per_node = 1;
    std::optional<double> walltime_s; ///< nothing: as long as the study is expected to take
};

struct JobSize {
    int nodes = 1; ///< no more than the batches can keep busy
    int ranks = 1;
    double core_seconds = 0.0;    ///< expected for everything that is missing
    double longest_batch_s = 0.0; ///< hardly exceeded by any batch
    double compute_s = 0.0;       ///< expected on these ranks
    double walltime_s = 0.0;      ///< limit of one job, whole minutes unless the user gave it
    std::int64_t jobs = 1;        ///< how often the job is expected to start
    bool pace_is_learned = false; ///< else the reference machine's times
};

/// Batches as study::make_batches plans them (cost in seconds of the reference machine), and what
/// is known of this machine's pace. Throws core::InputError if the walltime that the user gave is
/// too short for the longest batch.
[[nodiscard]] JobSize size_job(const std::vector<farm::Batch>& batches, const farm::Pace& pace,
                               const JobRequest& request);

} // namespace culm::cluster
