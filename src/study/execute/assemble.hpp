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

/// What the study file states besides the points; its version is the entry of that name.
[[nodiscard]] archive::StudyDescription
description_of(const Study& study,
               const std::vector<std::pair<std::string, std::string>>& provenance);

/// (points, factors), row-major, in the units of the factors' keys.
[[nodiscard]] std::vector<double> design_in_config_units(const Design& design);

/// Writes the study file if the journals (and an older study file) hold every point, and removes
/// the journals then. Returns false, leaving everything as it is, while points are missing.
/// Throws core::StorageError; journals stay in that case.
[[nodiscard]] bool
assemble_archive(const Study& study, const StudyFolder& folder,
                 const std::vector<std::pair<std::string, std::string>>& provenance);

struct MergeOutcome {
    std::int64_t points = 0;
    std::int64_t completed = 0;
    std::int64_t failed = 0;
    std::int64_t missing = 0;
    std::int64_t repeated = 0;           ///< points with an outcome in more than one folder
    std::vector<std::int64_t> differing; ///< those of them whose outcomes are not the same
};

/// Writes target's study.h5 from all that the source folders hold; sources stay as they are, and
/// points that none of them has are marked as missing. A completed outcome counts before a failed
/// one, else that of the folder named first. `provenance` are facts about this program.
/// InputError: a source holds no study or another one, is being written, says nothing of its
/// design, or the target exists already. StorageError: damage, disk full.
[[nodiscard]] MergeOutcome
merge_folders(const std::vector<StudyFolder>& sources, const StudyFolder& target,
              const std::vector<std::pair<std::string, std::string>>& provenance);

} // namespace culm::study
