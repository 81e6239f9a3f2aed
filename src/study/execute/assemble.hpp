// SPDX-License-Identifier: BSD-3-Clause
// The study file from the journals of one folder or of several.
#pragma once

#include "archive/study/description.hpp"
#include "study/execute/plan.hpp"
#include "study/execute/study_folder.hpp"

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace culm::study {

/// Contents of the study file besides the points; its version is the entry of that name.
[[nodiscard]] archive::StudyDescription description_of(const Study& study,
                                                       const archive::Texts& provenance);

/// (points, factors), row-major, in the units of the factors' keys.
[[nodiscard]] std::vector<double> design_in_config_units(const Design& design);
/// `facts` about this program, and what describes the study: its configuration, files, name, seed.
[[nodiscard]] archive::Texts provenance_of(const StudyConfig& config, archive::Texts facts);

/// Writes the study file if the journals (and an older study file) contain every point, and then
/// removes the journals. Returns false and changes nothing if points are missing. Throws
/// core::StorageError; the journals remain in that case.
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

/// Writes target's study.h5 from the contents of the source folders, which do not change. Points
/// that are in none of them are marked as missing. A completed outcome takes precedence over a
/// failed one; otherwise the folder named first does. `provenance` are facts about this program.
/// InputError: a source contains no study or another one, is being written, does not describe its
/// design, or the target exists already. StorageError: damage, disk full.
[[nodiscard]] MergeOutcome merge_folders(const std::vector<StudyFolder>& sources,
                                         const StudyFolder& target,
                                         const archive::Texts& provenance);

} // namespace culm::study
