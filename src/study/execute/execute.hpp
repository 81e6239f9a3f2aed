// SPDX-License-Identifier: BSD-3-Clause
// Runs a study over the ranks of a farm and writes its archive.
#pragma once

#include "archive/point_record.hpp"
#include "archive/study/description.hpp"
#include "farm/farm.hpp"
#include "study/execute/plan.hpp"
#include "study/execute/study_folder.hpp"

#include <functional>
#include <string>
#include <utility>
#include <vector>

namespace culm::study {

/// The record of one case.
using ComputePoint = std::function<archive::PointRecord(const run::CaseSpec& spec)>;

struct ExecuteOptions {
    ResumeOptions folder; ///< what to do if the folder holds the study already
    farm::FarmOptions farm;
    /// For the lock of the folder and those of the journals: a killed job's processes may outlive
    /// it by seconds.
    archive::LockWait lock_wait;
    /// Facts about this program for the archive's provenance: name and text.
    archive::Texts provenance;
    /// Called on rank 0 before the first point is started, with the plan of the run and the pace
    /// that earlier runs in the folder measured; may be empty.
    std::function<void(const Estimate& plan, const farm::Pace& pace)> announce;
    /// Called instead of the simulation and the fit, to test and to measure everything around them;
    /// may be empty.
    ComputePoint compute_point;
};

struct ExecuteOutcome {
    farm::Summary farm;              ///< of this run: points computed before are not in it
    std::int64_t resumed_points = 0; ///< found computed when the run began
    bool archive_is_complete = false;
    double assembly_s = 0.0; ///< wall time from the journals to the study file
    /// Expected time of the shortest of this run's batches, s.
    double shortest_batch_s = 0.0;
};

/// Every point is marked in its rank's journal before it is started. A point during which a process
/// has died before is computed in its own batch; a point that reached the crash limit is recorded
/// as failed (archive::rank_died) without another try.
/// Computes the points that `folder` lacks and, once none is missing, writes the study file from
/// the ranks' journals and removes them. Each point is in its rank's journal before it is counted;
/// the study file's data do not depend on which rank computed what. Collective over the
/// communicator; without one (nullptr) this process does everything.
/// Throws core::InputError and core::StorageError, on every rank alike.
[[nodiscard]] ExecuteOutcome execute(const Study& study, const StudyFolder& folder,
                                     const farm::Communicator* communicator,
                                     const ExecuteOptions& options);

} // namespace culm::study
