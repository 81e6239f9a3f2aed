// SPDX-License-Identifier: BSD-3-Clause
// DIR/journal/pace.json: what the points of a study took so far, for the next run and for sizing
// jobs.
#pragma once

#include "farm/batch.hpp"
#include "farm/communicator.hpp"
#include "farm/pace.hpp"
#include "study/study_folder.hpp"

#include <vector>

namespace culm::study {

/// Cost unit: seconds on the reference machine (study::estimated_seconds). Nothing known if there
/// is no such file or it cannot be understood: then times are learned anew.
[[nodiscard]] farm::Pace read_pace(const StudyFolder& folder);

/// Replaces the file at once, as long as the folder has journals. A failure is ignored: points do
/// not depend on it.
void write_pace(const StudyFolder& folder, const farm::Pace& pace);

/// What earlier runs left about the times of these batches, the same on every rank. It weighs no
/// more than one batch for each rank: the machine may be another one. Collective.
[[nodiscard]] farm::Pace earlier_pace(const StudyFolder& folder,
                                      const std::vector<farm::Batch>& batches,
                                      const farm::Communicator* communicator);

/// Expected for the cheapest of the batches, s; as make_batches plans while nothing is known.
[[nodiscard]] double shortest_expected_time(const std::vector<farm::Batch>& batches,
                                            const farm::Pace& pace);

} // namespace culm::study
