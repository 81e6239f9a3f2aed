// SPDX-License-Identifier: BSD-3-Clause
// How much a solution that has stopped could still gain.
#pragma once

#include "calibrate/joint_residuals.hpp"

#include <optional>
#include <vector>

namespace culm::calibrate {

/// By how much the sum of squares over the noise would fall in one Gauss-Newton step from the
/// prepared point, gᵀ (Jᵀ J)⁻¹ g over the parameters that can move: those that are not held
/// (`is_held`; missing entries are false) and do not stand at a bound that the step would cross.
/// Residuals beyond `robust_width` weigh as in Huber's loss. A step that a trust region shortens
/// promises less than this in directions that the readings hardly tell apart, and may end a
/// solution many standard errors away from the best one.
[[nodiscard]] double remaining_gain(const JointResiduals& residuals,
                                    const std::vector<bool>& is_held,
                                    std::optional<double> robust_width);

} // namespace culm::calibrate
