// SPDX-License-Identifier: BSD-3-Clause
// A number of the model that a fit may change.
#pragma once

#include "physics/effects/effect.hpp"
#include "run/sensitivities.hpp"

#include <string>
#include <vector>

namespace culm::fit {

struct FreeParameter {
    run::CaseParameter
        access;         ///< which it is, how to read and to set it in a case; its typical size
    std::string unit;   ///< "Pa"; empty for a pure number
    double lower = 0.0; ///< allowed range; the bounds belong to it
    double upper = 0.0;
    physics::FittedAs fitted_as = physics::FittedAs::Itself; ///< else lower must be positive
    bool is_place = false;                                   ///< as physics::EffectParameter's
    double absent = 0.0;                                     ///< likewise
};

/// Y (Pa) and β, both as logarithms, and the tip's deflection before the release (m).
[[nodiscard]] std::vector<FreeParameter> baseline_free_parameters();

/// The number that the fit works on: its logarithm, its inverse over that of its size, or the
/// number over its size in `spec`.
[[nodiscard]] double to_internal(const FreeParameter& parameter, const run::CaseSpec& start,
                                 double value);
[[nodiscard]] double from_internal(const FreeParameter& parameter, const run::CaseSpec& start,
                                   double internal);
/// d value/d internal at `value`.
[[nodiscard]] double value_per_internal(const FreeParameter& parameter, const run::CaseSpec& start,
                                        double value);

/// What the chain is differentiated by: the parameter, or its inverse, which can vanish.
[[nodiscard]] run::CaseParameter differentiated_by(const FreeParameter& parameter);
/// d/d value from d/d that, at `value`.
[[nodiscard]] double derivative_by_value(const FreeParameter& parameter, double value,
                                         double derivative);

} // namespace culm::fit
