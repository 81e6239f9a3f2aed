// SPDX-License-Identifier: BSD-3-Clause
#include "physics/effects/effect.hpp"

namespace culm::physics {

std::string_view to_string(FittedAs fitted_as) {
    switch (fitted_as) {
    case FittedAs::Itself:
        return "as it is";
    case FittedAs::Logarithm:
        return "as its logarithm";
    case FittedAs::Inverse:
        return "as its inverse";
    }
    return "as it is";
}

std::string_view to_string(Family family) {
    switch (family) {
    case Family::MaterialDamping:
        return "material damping";
    case Family::Air:
        return "air";
    case Family::Clamp:
        return "clamp";
    case Family::StemGeometry:
        return "stem geometry";
    case Family::SupportAndCamera:
        return "support and camera";
    case Family::Release:
        return "release";
    case Family::Weight:
        return "weight";
    case Family::Own:
        return "own law";
    }
    return "own law";
}

bool is_one_law(Family family) {
    return family == Family::MaterialDamping || family == Family::Air;
}

std::vector<EffectParameter> Effect::parameters_for(const StemParameters<double>& stem) const {
    std::vector<EffectParameter> parameters = card_.parameters;
    if (suit_ != nullptr)
        suit_(stem, parameters);
    return parameters;
}

std::vector<PlanarPart> Effect::planar_parts(std::span<const double> values) const {
    return card_.planar_parts == nullptr ? std::vector<PlanarPart>() : card_.planar_parts(values);
}

} // namespace culm::physics
