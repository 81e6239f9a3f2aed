// SPDX-License-Identifier: BSD-3-Clause
// comparison.h5: the arrays of a comparison (docs/compare.md).
#pragma once

#include "diagnose/ladder.hpp"
#include "measure/folder/measurement.hpp"

#include <filesystem>

namespace culm::cli {

/// Times, heights, measured deflections and, of every model that has a fit, what it predicts and
/// leaves, the spectrum of that, and the swing in windows. Throws core::StorageError.
void write_comparison_arrays(const std::filesystem::path& file, const diagnose::Ladder& ladder,
                             const measure::Measurement& measurement);

} // namespace culm::cli
