// SPDX-License-Identifier: BSD-3-Clause
// The smallest size at which an effect would be detected in addition to the best model.
#pragma once

#include "diagnose/search/search.hpp"

#include <string>
#include <vector>

namespace culm::diagnose {

struct DetectionLimit {
    std::string effect;
    std::string rig;       ///< whose stems have it; empty: the one stem
    std::string failure;   ///< why it is unknown; empty if it is known
    std::string parameter; ///< that gives the effect its size
    std::string unit;
    double value = 0.0;            ///< at three standard deviations of the noise of all stems
    double of_one = 0.0;           ///< the same of the rig's median stem
    bool is_beyond_bounds = false; ///< no possible size of the effect could be seen
    /// Relative change of Y and β by which the fit of one stem would hide an effect of that size.
    double youngs_modulus_bias = 0.0;
    double damping_bias = 0.0;
};

/// Detection limits of the candidates that the best model of a search does not contain, from the
/// columns of its last prediction. The part that the model's own parameters can imitate is removed.
/// One stem: of all candidates; an effect with several locations or sizes is seen in the one that
/// is seen best. Several stems: of the first size of every candidate of a rig, with the shared
/// numbers known.
[[nodiscard]] std::vector<DetectionLimit> detection_limits(const SearchResult& search);

} // namespace culm::diagnose
