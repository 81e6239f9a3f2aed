// SPDX-License-Identifier: BSD-3-Clause
// The study file from the ranks' journals.
#pragma once

#include "archive/study/description.hpp"
#include "study/plan.hpp"
#include "study/study_folder.hpp"

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

} // namespace culm::study
