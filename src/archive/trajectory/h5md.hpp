// SPDX-License-Identifier: BSD-3-Clause
// The parts of H5MD 1.1 that study files and files of trajectories have in common.
#pragma once

#include "archive/hdf5/handle.hpp"
#include "archive/hdf5/write.hpp"
#include "archive/study/description.hpp"

#include <string>

namespace culm::archive {

/// Author, creator and version of H5MD.
void write_h5md(const Hdf5Output& output, const StudyDescription& description);

/// /histories/time and /histories/step, which all trajectories of a file share.
GroupHandle create_histories(const Hdf5Output& output, const StudyDescription& description);

/// The particle group of this path, without the positions' values; returns its group `position`.
/// Sample times and numbers are hard links to those of create_histories, as H5MD proposes for
/// elements that are sampled together.
[[nodiscard]] GroupHandle create_particle_group(const Hdf5Output& output, const std::string& path);

/// Layout of the positions' values, (samples, spheres, 3), without chunks.
[[nodiscard]] DatasetLayout position_layout(const StudyDescription& description);

} // namespace culm::archive
