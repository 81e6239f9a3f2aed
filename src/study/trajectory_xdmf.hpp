// SPDX-License-Identifier: BSD-3-Clause
// The XDMF text by which ParaView finds a trajectory in a study file.
#pragma once

#include "archive/study/description.hpp"

#include <string>

namespace culm::study {

/// XDMF 2.2 (xdmf.org, "XDMF Model and Format"): a temporal collection with one grid per sample, a
/// polyline through the spheres whose coordinates are a hyperslab of the trajectory's dataset
/// (samples, spheres, 3). `archive` is the study file, relative to the XDMF file or absolute;
/// `group` the trajectory's particle group.
[[nodiscard]] std::string trajectory_xdmf(const std::string& archive, const std::string& group,
                                          const archive::StudyDescription& description);

} // namespace culm::study
