// SPDX-License-Identifier: BSD-3-Clause
// A number of the model that a fit may change.
#pragma once

#include "physics/effects/effect.hpp"
#include "run/sensitivities.hpp"

#include <vector>

namespace culm::fit {

/// Described as a number of an effect is. Its range includes its bounds, and `lower` is positive
/// unless it is fitted as itself. A number of the plain chain has no name, meaning or scale here.
struct FreeParameter : physics::EffectParameter {
    run::CaseParameter access; ///< its id, its getter and setter for a case, the size for its steps
};

/// A number of the plain chain.
[[nodiscard]] FreeParameter
chain_parameter(run::CaseParameter access, const char* unit, double lower, double upper,
                physics::FittedAs fitted_as = physics::FittedAs::Itself);

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

/// Step of central differences, relative to a number's size. Where the function is smooth, their
/// error is the square of this step, and that of rounding is 1e-16 over the step.
constexpr double relative_step = 1e-5;

/// The cases a step below and a step above a parameter's value.
struct SteppedCases {
    run::CaseSpec below, above;
    double distance; ///< between their coordinates of the parameter
};
[[nodiscard]] SteppedCases stepped(const run::CaseSpec& spec, const FreeParameter& parameter);

} // namespace culm::fit
