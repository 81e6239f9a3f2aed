// SPDX-License-Identifier: BSD-3-Clause
// Writing the trajectories of one rank into HDF5 files that the death of the process cannot damage.
//
// HDF5 loses a file whose metadata are being written when the process dies, also if it is flushed
// after every trajectory (bench/trajectory_designs.cpp kills both designs). Here the metadata are
// written once: a file begins with room for many trajectories, contiguous datasets whose space is
// allocated and not yet written, and HDF5 closes it. From then on it is a complete HDF5 file. Each
// trajectory is one write to the address of a free dataset, without HDF5, and counts when the
// journal holds its place and its checksum.
//
// Traps: the space of unused datasets is a hole at the end of the file, so the file looks larger
// than it is; and HDF5 has no checksum for contiguous datasets, so readers must compare that of the
// place.
#pragma once

#include "archive/file_descriptor.hpp"
#include "archive/study/description.hpp"
#include "archive/trajectory/place.hpp"

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <vector>

namespace culm::archive {

/// Appends the trajectories of one rank to its files in a folder.
class TrajectoryWriter {
  public:
    /// `description`: times, spheres, precision and version of the study; it must outlive the
    /// writer. `expected`: about how many trajectories this rank will write; it bounds the room in
    /// a file. Creates nothing before the first trajectory.
    TrajectoryWriter(std::filesystem::path folder, std::uint32_t rank,
                     const StudyDescription& description, std::int64_t expected);

    /// Writes one trajectory, (samples, spheres, 3) row-major in m. It is in the kernel when this
    /// returns. StorageError: disk full, I/O error; the next call may succeed.
    [[nodiscard]] TrajectoryPlace write(std::span<const double> positions);
    /// fdatasync of the current file.
    void sync();

  private:
    /// A new file with all its room; files of earlier runs are never opened again.
    void start_file();

    std::filesystem::path folder_;
    const StudyDescription& description_;
    std::int64_t expected_;
    std::optional<FileDescriptor> file_;
    std::vector<std::uint64_t> slots_; ///< addresses in the current file, bytes
    TrajectoryPlace next_;             ///< of the next trajectory, without its checksum
    std::vector<float> narrowed_;
    std::vector<double> widened_; ///< what a reader of narrowed_ gets
};

} // namespace culm::archive
