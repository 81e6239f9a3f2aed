// SPDX-License-Identifier: BSD-3-Clause
// Runs a study over the ranks of a farm and writes its archive: the study file from the journals of
// one folder or of several.
#pragma once

#include "archive/point_record.hpp"
#include "archive/study/description.hpp"
#include "farm/farm.hpp"
#include "study/execute/folder_state.hpp"
#include "study/execute/plan.hpp"
#include "study/execute/study_folder.hpp"

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace culm::study {

/// The record of one case.
using ComputePoint = std::function<archive::PointRecord(const run::CaseSpec& spec)>;

/// Every count-th point from the number-th on: the share of one of several jobs, which have a
/// folder each.
struct Part {
    std::int64_t number = 1; ///< 1 … count
    std::int64_t count = 1;
};

struct ExecuteOptions {
    Part part;
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
    std::vector<std::string> lost_trajectories; ///< of points that were computed again, in words
    bool archive_is_complete = false;
    double storage_s = 0.0;  ///< of this rank, in its journal and trajectories
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

/// The result of extend_folder.
struct Extension {
    std::int64_t kept = 0;   ///< outcomes of the stored study that the new one has
    std::int64_t points = 0; ///< of the new study
    std::string former;      ///< the stored archive is kept here, if its points are computed again
};

/// If the folder holds another study that `study` extends, replaces its archive by that of `study`,
/// in which the new points are missing; execute computes them. Nothing if the folder is empty, or
/// holds this study or one that differs in its fixed settings. `facts` are about this program.
/// Throws core::InputError as extension_of and as prepare_folder, core::StorageError.
[[nodiscard]] std::optional<Extension> extend_folder(const Study& study, const StudyFolder& folder,
                                                     const archive::Texts& facts,
                                                     const archive::LockWait& lock_wait = {});

/// Contents of the study file besides the points; its version is the entry of that name.
[[nodiscard]] archive::StudyDescription description_of(const Study& study,
                                                       const archive::Texts& provenance);

/// `facts` about this program, and what describes the study: its configuration, files, name, seed.
[[nodiscard]] archive::Texts provenance_of(const StudyConfig& config, archive::Texts facts);

/// Writes the study file if the journals (and an older study file) contain every point, and then
/// removes the journals. Returns false and changes nothing if points
/// are missing. Throws core::StorageError; the journals remain in that case.
[[nodiscard]] bool assemble_archive(const Study& study, const StudyFolder& folder,
                                    const archive::Texts& provenance);

struct MergeOutcome {
    std::int64_t points = 0;
    std::int64_t completed = 0;
    std::int64_t failed = 0;
    std::int64_t missing = 0;
    std::int64_t repeated = 0;           ///< points with an outcome in more than one folder
    std::vector<std::int64_t> differing; ///< those of them whose outcomes are not the same
};

/// Writes target's study.h5 from the contents of the source folders, which do not change. It holds
/// all trajectories itself. Points that are in none of the folders are marked as missing. A
/// completed outcome takes precedence over a failed one; otherwise the folder named first does.
/// `provenance` are facts about this program. InputError: a source contains no study or another
/// one, is being written, does not describe its design, or the target exists already. StorageError:
/// damage, disk full.
[[nodiscard]] MergeOutcome merge_folders(const std::vector<StudyFolder>& sources,
                                         const StudyFolder& target,
                                         const archive::Texts& provenance);

} // namespace culm::study
