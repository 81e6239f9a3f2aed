// SPDX-License-Identifier: BSD-3-Clause
// calibration.json: what culm calibrate found (docs/calibration-format.md).
#pragma once

#include "calibrate/bulk_export.hpp"
#include "calibrate/calibration.hpp"

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace culm::cli {

/// One stem that was calibrated.
[[nodiscard]] nlohmann::json calibration_json(const calibrate::Calibration& calibration,
                                              const std::string& law);

/// The member "via" of a stem: Y and β by a study's regressions.
[[nodiscard]] nlohmann::json study_calibration_json(const calibrate::StudyCalibration& found,
                                                    const std::string& study);

/// The member "population": of two calibrated stems or more, else null. `stems` as the file holds
/// them.
[[nodiscard]] nlohmann::json population_json(const nlohmann::json& stems);

/// The calibrated stems of a file's text, or only the one of that id (empty: all). Throws
/// core::InputError if it is not such a file or has no such stem.
[[nodiscard]] std::vector<calibrate::BulkStem>
bulk_stems(const std::string& text, const std::string& file, const std::string& id);

} // namespace culm::cli
