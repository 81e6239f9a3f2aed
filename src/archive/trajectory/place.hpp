// SPDX-License-Identifier: BSD-3-Clause
// Where a trajectory is stored outside of the study file, and how the places are named.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include <fmt/format.h>

namespace culm::archive {

/// Folder of the trajectories, next to the study file.
inline constexpr std::string_view trajectory_folder_name = "trajectories";
inline constexpr std::string_view trajectory_format_name = "culm-trajectories";

/// One trajectory in a file of that folder.
struct TrajectoryPlace {
    std::uint32_t rank = 0;  ///< that wrote it
    std::uint32_t file = 0;  ///< number of the file among those of the rank
    std::uint32_t slot = 0;  ///< number of the particle group in the file
    std::uint32_t crc32 = 0; ///< of the positions as doubles, little-endian

    bool operator==(const TrajectoryPlace&) const = default;

    [[nodiscard]] std::string file_name() const {
        return fmt::format("rank-{:05}-{:04}.h5", rank, file);
    }
    /// Path of the particle group in the file.
    [[nodiscard]] std::string group() const {
        return fmt::format("/particles/trajectory_{:04}", slot);
    }
};

} // namespace culm::archive
