// SPDX-License-Identifier: BSD-3-Clause
#include "physics/effects/effect.hpp"

#include <array>

namespace culm::physics {

std::string_view to_string(FittedAs fitted_as) {
    constexpr std::array names{"as it is", "as its logarithm", "as its inverse"};
    return names[static_cast<std::size_t>(fitted_as)];
}

std::string_view to_string(Family family) {
    constexpr std::array names{"material damping",   "air",     "clamp",  "stem geometry",
                               "support and camera", "release", "weight", "own law"};
    return names[static_cast<std::size_t>(family)];
}

bool is_one_law(Family family) {
    return family == Family::MaterialDamping || family == Family::Air;
}

std::vector<EffectParameter> Effect::parameters_for(const StemParameters<double>& stem) const {
    std::vector<EffectParameter> suited = parameters;
    if (suit_ != nullptr)
        suit_(stem, suited);
    return suited;
}

std::vector<PlanarPart> Effect::planar_parts_of(std::span<const double> values) const {
    return planar_parts == nullptr ? std::vector<PlanarPart>() : planar_parts(values);
}

} // namespace culm::physics
