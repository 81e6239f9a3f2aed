// SPDX-License-Identifier: BSD-3-Clause
// diagnosis.h5: the measured and the modelled motion of a diagnosis (docs/diagnosis.md).
#pragma once

#include "diagnose/diagnosis.hpp"
#include "measure/folder/measurement.hpp"

#include <filesystem>
#include <span>

namespace culm::cli {

/// A group recording_K for each recording: times, heights, measured deflections and what the
/// published chain and, if it is another one, the best model that was reached predict and leave.
/// Throws core::StorageError.
void write_diagnosis_arrays(const std::filesystem::path& file, const diagnose::Diagnosis& diagnosis,
                            std::span<const measure::Measurement> recordings);

} // namespace culm::cli
