// SPDX-License-Identifier: BSD-3-Clause
// The smallest size at which an effect would be detected in addition to the best model.
#pragma once

#include "diagnose/search/search.hpp"

#include <limits>
#include <string>
#include <vector>

namespace culm::diagnose {

struct DetectionLimit {
    std::string effect;
    std::string failure;   ///< why it is unknown; empty if it is known
    std::string parameter; ///< that gives the effect its size
    std::string unit;
    double value = 0.0;            ///< at three standard deviations of the noise
    bool is_beyond_bounds = false; ///< no possible size of the effect could be seen
    /// Relative change of Y and β by which the fit would hide an effect of that size.
    double youngs_modulus_bias = 0.0;
    double damping_bias = 0.0;
};

/// Detection limits of all candidates that the best model of a search of one stem does not contain,
/// from the columns of its last prediction. An effect with several locations or sizes is seen in
/// the one that is seen best. The part that the model's own parameters can imitate is removed.
[[nodiscard]] std::vector<DetectionLimit> detection_limits(const SearchResult& search);

/// Detection limit of an effect of a rig.
struct SharedLimit {
    std::string effect;
    std::string rig;
    std::string parameter;
    std::string unit;
    double of_one = std::numeric_limits<double>::infinity(); ///< of the median stem
    double of_all = std::numeric_limits<double>::infinity(); ///< of all stems together
};

template <class To>
void describe(To& to, const SharedLimit& limit) {
    to("effect", limit.effect);
    to("rig", limit.rig);
    to("parameter", limit.parameter);
    to("unit", limit.unit);
    to("one_stem", limit.of_one);
    to("all_stems", limit.of_all);
}

/// Three standard deviations of the first size of every candidate of a rig that the best model does
/// not contain, with the shared numbers known.
[[nodiscard]] std::vector<SharedLimit> shared_limits(const SearchResult& search);

} // namespace culm::diagnose
