// SPDX-License-Identifier: BSD-3-Clause
#include "fit/model/parameter.hpp"

#include <cmath>

namespace culm::fit {

namespace {

using physics::FittedAs;

double size_of(const FreeParameter& parameter, const run::CaseSpec& start) {
    if (parameter.access.scale > 0.0)
        return parameter.access.scale;
    const double value = std::abs(parameter.access.get(start));
    return value > 0.0 ? value : 1.0;
}

} // namespace

std::vector<FreeParameter> baseline_free_parameters() {
    std::vector<run::CaseParameter> baseline = run::baseline_parameters();
    // Wide enough for anything between gelatine and diamond: a fit that ends there has failed.
    return {{std::move(baseline[0]), "Pa", 1e3, 1e13, FittedAs::Logarithm},
            {std::move(baseline[1]), "", 1e-4, 1e6, FittedAs::Logarithm},
            {std::move(baseline[2]), "m", -10.0, 10.0}};
}

double to_internal(const FreeParameter& parameter, const run::CaseSpec& start, double value) {
    if (parameter.fitted_as == FittedAs::Logarithm)
        return std::log(value);
    const double size = size_of(parameter, start);
    return parameter.fitted_as == FittedAs::Inverse ? size / value : value / size;
}

double from_internal(const FreeParameter& parameter, const run::CaseSpec& start, double internal) {
    if (parameter.fitted_as == FittedAs::Logarithm)
        return std::exp(internal);
    const double size = size_of(parameter, start);
    return parameter.fitted_as == FittedAs::Inverse ? size / internal : internal * size;
}

double value_per_internal(const FreeParameter& parameter, const run::CaseSpec& start,
                          double value) {
    if (parameter.fitted_as == FittedAs::Logarithm)
        return value;
    const double size = size_of(parameter, start);
    // d(1/internal)/d(internal) = −value².
    return parameter.fitted_as == FittedAs::Inverse ? -value * value / size : size;
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

double derivative_by_value(const FreeParameter& parameter, double value, double derivative) {
    return parameter.fitted_as == FittedAs::Inverse ? -derivative / (value * value) : derivative;
}

} // namespace culm::fit
