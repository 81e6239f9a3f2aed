// SPDX-License-Identifier: BSD-3-Clause
// How the laws of a real laboratory differ from those of culm's library.
#pragma once

#include <vector>

namespace culm::beam {

/// Part of a relaxing material: its share of the fraction, and its time over the nominal one.
struct RelaxationPart {
    double share = 1.0;
    double time_ratio = 1.0;
};

/// The default has no error. Each error changes the effect that it belongs to; those of the second
/// mode change every beam.
struct LawErrors {
    /// p of the force per length c |v|ᵖ, which replaces quadratic drag.
    double drag_exponent = 2.0;
    double drag_speed = 1.0; ///< at which both forces are equal, m/s
    /// Loss factor of a soft clamp at the first frequency: a dashpot beside its spring.
    double clamp_loss_factor = 0.0;
    std::vector<RelaxationPart> relaxation; ///< replaces the one time; empty: one time
    double second_frequency_share = 0.0;    ///< by which the second natural frequency is larger
    double second_loss_ratio = 1.0;         ///< of the second mode's internal damping
};

} // namespace culm::beam
