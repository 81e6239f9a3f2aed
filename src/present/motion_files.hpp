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

/// Of every frame and height the measured deflection, and that of each model under its label; mm.
[[nodiscard]] std::string
deflections_csv(const measure::Measurement& measurement,
                const std::vector<std::pair<std::string, const fit::RecordingFit*>>& models);

/// Times, heights, measured deflections and, of every model that has a fit, what it predicts and
/// leaves, the spectrum of that, and the swing in windows. Throws core::StorageError.
void write_comparison_arrays(const std::filesystem::path& file, const diagnose::Ladder& ladder,
                             const measure::Measurement& measurement);

/// A group recording_K for each recording: times, heights, measured deflections and what the
/// published chain and, if it is another one, the best model that was reached predict and leave.
/// Throws core::StorageError.
void write_diagnosis_arrays(const std::filesystem::path& file, const diagnose::Diagnosis& diagnosis,
                            std::span<const measure::Measurement> recordings);

} // namespace culm::present
