// SPDX-License-Identifier: BSD-3-Clause
// By when a run must have ended: --walltime, or what the batch system says.
#pragma once

#include "farm/batch.hpp"
#include "farm/communicator.hpp"

#include <optional>
#include <string>

namespace culm::cli {

struct RunDeadline {
    farm::Clock::time_point time; ///< on this rank's clock
    std::string text;             ///< what limits the run, for people
};

/// `walltime` as it was given, counted from `start`; if it is empty, rank 0 asks the batch system.
/// A fiftieth of the time, at least 1 s and at most 60 s, is left for ending in order. Nothing if
/// there is no limit. Throws core::InputError on every rank. Collective.
[[nodiscard]] std::optional<RunDeadline> run_deadline(const std::string& walltime,
                                                      farm::Clock::time_point start,
                                                      const farm::Communicator* communicator);

} // namespace culm::cli
