// SPDX-License-Identifier: BSD-3-Clause
#include "calibrate/free_parameter.hpp"

#include <cmath>

namespace culm::calibrate {
namespace {

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
    return {{std::move(baseline[0]), "Pa", 1e3, 1e13, true},
            {std::move(baseline[1]), "", 1e-4, 1e6, true},
            {std::move(baseline[2]), "m", -10.0, 10.0, false}};
}

double to_internal(const FreeParameter& parameter, const run::CaseSpec& start, double value) {
    return parameter.is_logarithmic ? std::log(value) : value / size_of(parameter, start);
}

double from_internal(const FreeParameter& parameter, const run::CaseSpec& start, double internal) {
    return parameter.is_logarithmic ? std::exp(internal) : internal * size_of(parameter, start);
}

} // namespace culm::calibrate
