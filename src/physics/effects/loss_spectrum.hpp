// SPDX-License-Identifier: BSD-3-Clause
// Maxwell branches that together lose the same share of energy at every frequency of a band.
#pragma once

#include "physics/chain_model.hpp"

#include <span>
#include <vector>

namespace culm::physics {

/// Frequencies, Hz (or over the first natural frequency).
struct FrequencyBand {
    double lowest = 0.0;
    double highest = 0.0;
};

/// Where hysteretic damping is kept constant, over the first natural frequency: modes 1 to 3 of a
/// cantilever lie at 1, 6.27 and 17.5, and a mass at the tip lowers them.
inline constexpr FrequencyBand hysteretic_band{1.0 / 3.0, 40.0};

/// Six branches with relaxation times spread evenly over the logarithm of the band's periods. The
/// condition E'' = η E' at frequencies of the band is linear in their stiffnesses, which are its
/// least-squares solution (Emmerich & Korn 1987). They bear nothing while the stem is held.
/// `loss_factor` from 0 to 0.5.
[[nodiscard]] std::vector<MaxwellBranch<double>> constant_loss_branches(double loss_factor,
                                                                        const FrequencyBand& band);

/// E''/E' of a spring with these branches beside it, at a frequency in Hz.
[[nodiscard]] double loss_factor_of(std::span<const MaxwellBranch<double>> branches,
                                    double frequency);

} // namespace culm::physics
