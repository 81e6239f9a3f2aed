// SPDX-License-Identifier: BSD-3-Clause
// A number of the model that a fit may change.
#pragma once

#include "physics/effects/effect.hpp"
#include "run/sensitivities.hpp"

#include <string>
#include <vector>

namespace culm::fit {

struct FreeParameter {
    run::CaseParameter access; ///< its id, its getter and setter for a case, its typical size
    std::string unit;          ///< "Pa"; empty for a pure number
    double lower = 0.0;        ///< allowed range, including its bounds
    double upper = 0.0;
    physics::FittedAs fitted_as = physics::FittedAs::Itself; ///< else lower must be positive
    bool is_place = false;                                   ///< as in physics::EffectParameter
    double absent = 0.0;                                     ///< likewise
    bool is_phase = false;                                   ///< likewise
    double known = 0.0;                                      ///< its value, known within …
    double known_within = 0.0;                               ///< … this; 0: it is not known
};

/// Y (Pa) as its logarithm, β, in which decay is linear and which may vanish, and the tip's
/// deflection before the release (m).
[[nodiscard]] std::vector<FreeParameter> baseline_free_parameters();

/// The coordinate in which a fit changes a parameter, and in which it has its prior: the number
/// itself, its logarithm or its inverse.
[[nodiscard]] double to_coordinate(physics::FittedAs fitted_as, double value);
[[nodiscard]] double from_coordinate(physics::FittedAs fitted_as, double coordinate);
/// d coordinate/d value.
[[nodiscard]] double coordinate_slope(physics::FittedAs fitted_as, double value);

/// The number by which the chain is differentiated: the parameter or its inverse, which may be 0.
[[nodiscard]] run::CaseParameter differentiated_by(const FreeParameter& parameter);
/// Converts a derivative by that number to the derivative by the coordinate, at `value`.
[[nodiscard]] double derivative_by_coordinate(const FreeParameter& parameter, double value,
                                              double derivative);

} // namespace culm::fit
