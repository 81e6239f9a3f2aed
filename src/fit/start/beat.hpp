// SPDX-License-Identifier: BSD-3-Clause
// The beat of a swing that leaves the plane of the pull, as the readings show it.
#pragma once

#include "fit/solve/fit.hpp"

#include <vector>

namespace culm::fit {

/// A e^{−δt} (cos²α cos ω₁t + sin²α cos ω₂t), ω₁,₂ = ω √(1 ± ε/2): what is seen from one side of a
/// stem with two planes of bending.
struct Beat {
    double angular_frequency = 0.0; ///< ω, 1/s
    double decay_rate = 0.0;        ///< δ, 1/s
    double split = 0.0;             ///< ε
    double angle = 0.0;             ///< α, rad, between 0 and π/2
    double amplitude = 0.0;         ///< A over that of the fitted chain at the release
};

/// The beats that explain the readings of `fit` best, the best first, at most `count`; none unless
/// the best explains a tenth of the fitted chain's residual swing. Frequency and decay are searched
/// about those of `fit`, whose first mode has `angular_frequency` and `decay_rate`.
[[nodiscard]] std::vector<Beat> recorded_beats(const RecordingFit& fit, double angular_frequency,
                                               double decay_rate, std::size_t count);

} // namespace culm::fit
