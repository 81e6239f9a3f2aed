// SPDX-License-Identifier: BSD-3-Clause
// The stem of the demonstration video, tests/data/demo-beam: a beam with internal damping only.
#pragma once

#include <string>

namespace culm::beam {

/// Young's modulus of the demonstration's stem, Pa.
inline constexpr double demo_youngs_modulus = 1.9e9;
/// Its damping time τ, s: the damping ratio of a mode is π f τ.
inline constexpr double demo_damping_time = 1e-4;

/// axis.csv: a line per frame of the video with the heights and deflections of the axis's points.
[[nodiscard]] std::string demo_axis_table();

} // namespace culm::beam
