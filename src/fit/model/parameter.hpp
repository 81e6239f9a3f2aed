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
};

/// Y (Pa) and β, both as logarithms, and the tip's deflection before the release (m).
[[nodiscard]] std::vector<FreeParameter> baseline_free_parameters();

/// The number that the optimiser changes: the logarithm of the value, its inverse over that of its
/// size, or the value over its size in `start`.
[[nodiscard]] double to_internal(const FreeParameter& parameter, const run::CaseSpec& start,
                                 double value);
[[nodiscard]] double from_internal(const FreeParameter& parameter, const run::CaseSpec& start,
                                   double internal);
/// d value/d internal at `value`.
[[nodiscard]] double value_per_internal(const FreeParameter& parameter, const run::CaseSpec& start,
                                        double value);

/// The number by which the chain is differentiated: the parameter or its inverse, which may be 0.
[[nodiscard]] run::CaseParameter differentiated_by(const FreeParameter& parameter);
/// Converts a derivative by that number at `value` to the derivative by the value.
[[nodiscard]] double derivative_by_value(const FreeParameter& parameter, double value,
                                         double derivative);

} // namespace culm::fit
