// SPDX-License-Identifier: BSD-3-Clause
// Reading trajectories that are stored outside of the study file.
#pragma once

#include "archive/hdf5/read.hpp"
#include "archive/trajectory/place.hpp"

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace culm::archive {

/// The folder of trajectories of a study. It never returns a number whose checksum is wrong: an
/// unwritten dataset reads as zeros.
class TrajectoryFolder {
  public:
    explicit TrajectoryFolder(std::filesystem::path folder) : folder_(std::move(folder)) {}

    /// (samples, spheres, 3) row-major, m. StorageError: the file is missing (it is named) or not a
    /// file of trajectories, or the checksum is wrong.
    [[nodiscard]] std::vector<double> read(const TrajectoryPlace& place);

  private:
    [[nodiscard]] const Hdf5Input& open(const std::string& file);

    std::filesystem::path folder_;
    std::map<std::string, Hdf5Input> open_; ///< some dozens of files by name
};

} // namespace culm::archive
