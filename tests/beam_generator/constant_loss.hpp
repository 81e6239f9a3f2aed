// SPDX-License-Identifier: BSD-3-Clause
// Hysteretic damping as a dense row of relaxing branches.
#pragma once

#include "beam_generator/beam_terms.hpp"

#include <vector>

namespace culm::beam {

/// E''/E' = `loss_factor` from a third of `first_frequency` (Hz) to 40 times it, the band in which
/// culm's library means it. Ten branches (culm has six), of which the weights are the fixed point
/// of "the loss at each branch's own frequency is right": another discretisation of the same law.
[[nodiscard]] std::vector<RelaxingBranch> constant_loss(double loss_factor, double first_frequency);

/// E''/E' of a spring with these branches beside it, at a frequency in Hz.
[[nodiscard]] double loss_factor_at(const std::vector<RelaxingBranch>& branches, double frequency);

} // namespace culm::beam
