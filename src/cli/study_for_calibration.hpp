// SPDX-License-Identifier: BSD-3-Clause
// What of a study's folder a calibration needs.
#pragma once

#include "calibrate/study_calibration.hpp"

#include <string>

namespace culm::cli {

/// Throws core::InputError if the folder holds no complete study of free vibrations.
[[nodiscard]] calibrate::StudyForCalibration study_for_calibration(const std::string& folder);

} // namespace culm::cli
