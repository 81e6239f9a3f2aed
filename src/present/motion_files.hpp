// SPDX-License-Identifier: BSD-3-Clause
// Measured and modelled motion as files: tables of deflections, comparison.h5 (docs/compare.md) and
// diagnosis.h5 (docs/diagnosis.md).
#pragma once

#include "diagnose/diagnosis.hpp"
#include "diagnose/ladder.hpp"
#include "measure/folder/measurement.hpp"

#include <filesystem>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace culm::present {

/// The measured deflection for every frame and height, and each model's under its label; mm.
[[nodiscard]] std::string
deflections_csv(const measure::Measurement& measurement,
                const std::vector<std::pair<std::string, const fit::RecordingFit*>>& models);

/// Times, heights and measured deflections, and for every fitted model the predictions, the
/// residuals, their spectrum, and the swing in windows. Throws core::StorageError.
void write_comparison_arrays(const std::filesystem::path& file, const diagnose::Ladder& ladder,
                             const measure::Measurement& measurement);

/// A group recording_K for each recording: times, heights, measured deflections, and predictions
/// and residuals of the published chain and, if it is a different model, of the best one.
/// Throws core::StorageError.
void write_diagnosis_arrays(const std::filesystem::path& file, const diagnose::Diagnosis& diagnosis,
                            std::span<const measure::Measurement> recordings);

} // namespace culm::present
