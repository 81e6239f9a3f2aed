// SPDX-License-Identifier: BSD-3-Clause
// Hysteretic damping as a dense row of relaxing branches.
#pragma once

#include "beam_generator/beam_terms.hpp"

#include <vector>

namespace culm::beam {

/// E''/E' = `loss_factor` from a third of `first_frequency` (Hz) to 40 times it, the band in which
/// culm's library uses it. Ten branches (culm has six), with weights that give the right loss at
/// the frequency of each branch: another discretisation of the same law.
[[nodiscard]] std::vector<RelaxingBranch> constant_loss(double loss_factor, double first_frequency);

/// E''/E' of a spring in parallel with these branches, at a frequency in Hz.
[[nodiscard]] double loss_factor_at(const std::vector<RelaxingBranch>& branches, double frequency);

} // namespace culm::beam
