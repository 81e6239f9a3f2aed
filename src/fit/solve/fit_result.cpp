// SPDX-License-Identifier: BSD-3-Clause
#include "fit/solve/fit_result.hpp"

#include "reduce/distributions.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace culm::fit {

double interval_half_width(const FittedParameter& parameter) {
    return reduce::normal_quantile_95 * parameter.standard_error;
}

bool is_absent(const FittedParameter& parameter) {
    return !(std::abs(parameter.value - parameter.absent) > interval_half_width(parameter));
}

const FittedParameter* RecordingFit::find(const physics::ParameterId& id) const {
    const auto found = std::ranges::find(parameters, id, &FittedParameter::id);
    return found == parameters.end() ? nullptr : &*found;
}

KnownPoint known_point(const RecordingFit& fit) {
    KnownPoint point{fit.prediction, {}};
    std::ranges::copy_if(fit.terms, std::back_inserter(point.inputs),
                         [](const ErrorTerm& term) { return term.kind == ErrorKind::StatedInput; });
    return point;
}

StartModels start_from(const Fit& fit) {
    StartModels start;
    for (const RecordingFit& part : fit.parts)
        start.push_back(part.model);
    return start;
}

std::vector<std::vector<double>> times_of(const Fit& fit) {
    std::vector<std::vector<double>> times;
    for (const RecordingFit& part : fit.parts)
        times.push_back(part.times);
    return times;
}

} // namespace culm::fit
