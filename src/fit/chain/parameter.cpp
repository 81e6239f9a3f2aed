// SPDX-License-Identifier: BSD-3-Clause
#include "fit/chain/parameter.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace culm::fit {

using physics::FittedAs;

FreeParameter chain_parameter(run::CaseParameter access, const char* unit, double lower,
                              double upper, FittedAs fitted_as) {
    FreeParameter parameter{{}, std::move(access)};
    parameter.unit = unit;
    parameter.lower = lower;
    parameter.upper = upper;
    parameter.fitted_as = fitted_as;
    return parameter;
}

std::vector<FreeParameter> baseline_free_parameters() {
    std::vector<run::CaseParameter> baseline = run::baseline_parameters();
    // Wide enough for anything between gelatine and diamond: a fit that ends there has failed.
    return {chain_parameter(std::move(baseline[0]), "Pa", 1e3, 1e13, FittedAs::Logarithm),
            chain_parameter(std::move(baseline[1]), "", 1e-4, 1e6),
            chain_parameter(std::move(baseline[2]), "m", -10.0, 10.0)};
}

double to_coordinate(FittedAs fitted_as, double value) {
    return fitted_as == FittedAs::Logarithm ? std::log(value)
           : fitted_as == FittedAs::Inverse ? 1.0 / value
                                            : value;
}

double from_coordinate(FittedAs fitted_as, double coordinate) {
    return fitted_as == FittedAs::Logarithm ? std::exp(coordinate)
           : fitted_as == FittedAs::Inverse ? 1.0 / coordinate
                                            : coordinate;
}

double coordinate_slope(FittedAs fitted_as, double value) {
    return fitted_as == FittedAs::Logarithm ? 1.0 / value
           : fitted_as == FittedAs::Inverse ? -1.0 / (value * value)
                                            : 1.0;
}

// A stiff clamp is a compliance near zero. The readings are smooth in the compliance and have a
// pole in the stiffness, so the chain is differentiated by the inverse, and the chain rule converts
// the derivative.
run::CaseParameter differentiated_by(const FreeParameter& parameter) {
    if (parameter.fitted_as != FittedAs::Inverse)
        return parameter.access;
    return {parameter.access.id,
            [get = parameter.access.get](const run::CaseSpec& spec) { return 1.0 / get(spec); },
            [set = parameter.access.set](run::CaseSpec& spec, double inverse) {
                set(spec, 1.0 / inverse);
            },
            1.0 / parameter.access.scale};
}

double derivative_by_coordinate(const FreeParameter& parameter, double value, double derivative) {
    return parameter.fitted_as == FittedAs::Logarithm ? derivative * value : derivative;
}

SteppedCases stepped(const run::CaseSpec& spec, const FreeParameter& parameter) {
    const double value = parameter.access.get(spec);
    const double step = relative_step * std::max(std::abs(value), parameter.access.scale);
    SteppedCases cases{spec, spec, 2.0 * step * coordinate_slope(parameter.fitted_as, value)};
    parameter.access.set(cases.below, value - step);
    parameter.access.set(cases.above, value + step);
    return cases;
}

} // namespace culm::fit
