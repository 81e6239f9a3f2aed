// SPDX-License-Identifier: BSD-3-Clause
// The smallest size at which an effect would be detected in addition to the best model.
#pragma once

#include "diagnose/model_search.hpp"

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

template <class Wire>
void fields(Wire& wire, DetectionLimit& limit) {
    wire(limit.effect, limit.failure, limit.parameter, limit.unit, limit.value,
         limit.is_beyond_bounds, limit.youngs_modulus_bias, limit.damping_bias);
}

/// Detection limits of all candidates that the best model of a search does not contain. The effect
/// is simulated in several sizes with the first mode kept by Y and β. The part that the model's own
/// parameters can imitate is removed.
[[nodiscard]] std::vector<DetectionLimit> detection_limits(const SearchResult& search,
                                                           const DiagnosisOptions& options);

} // namespace culm::diagnose
