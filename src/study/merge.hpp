// SPDX-License-Identifier: BSD-3-Clause
// One study file from the journals and archives of one or several folders of the same study.
#pragma once

#include "study/study_folder.hpp"

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace culm::study {

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
