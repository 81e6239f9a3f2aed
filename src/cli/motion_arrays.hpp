// SPDX-License-Identifier: BSD-3-Clause
// Measured and modelled deflections as arrays for HDF5 files.
#pragma once

#include "archive/hdf5/array_file.hpp"
#include "fit/solve/fit.hpp"
#include "measure/folder/measurement.hpp"

#include <string>
#include <vector>

namespace culm::cli {

/// An array of one dimension.
[[nodiscard]] archive::NamedArray series(std::string path, std::string unit,
                                         std::string description, std::vector<double> values);

/// `place`time, `place`height and `place`measured (time, height): the frames that `fit` used.
void add_measured(std::vector<archive::NamedArray>& arrays, const std::string& place,
                  const fit::RecordingFit& fit, const measure::Measurement& measurement);

/// `group`/predicted and `group`/residual (time, height).
void add_predicted(std::vector<archive::NamedArray>& arrays, const std::string& group,
                   const fit::RecordingFit& fit);

} // namespace culm::cli
