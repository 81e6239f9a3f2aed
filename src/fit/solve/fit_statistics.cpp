// SPDX-License-Identifier: BSD-3-Clause
#include "fit/solve/fit_statistics.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <tuple>

#include <fmt/core.h>

namespace culm::fit {
namespace {

/// A parameter is at a bound within this share of its value.
constexpr double nearness = 1e-6;
constexpr double rounding = 1e-12; ///< likewise of its range, which may span many decades

bool is_near(const FittedParameter& parameter, double bound) {
    switch (parameter.fitted_as) {
    case physics::FittedAs::Logarithm:
        return std::abs(std::log(parameter.value / bound)) < nearness;
    case physics::FittedAs::Inverse:
        return std::abs(1.0 / parameter.value - 1.0 / bound) < nearness / parameter.lower;
    case physics::FittedAs::Itself:
        break;
    }
    const double range = parameter.upper - parameter.lower;
    const double distance = std::abs(parameter.value - bound);
    return distance < rounding * range ||
           distance <
               nearness * std::min(range, std::max(std::abs(parameter.value), std::abs(bound)));
}

void add_part_parameters(RecordingFit& fit) {
    const std::vector<physics::ParameterId> ids = fit.model.free_ids();
    for (std::size_t k = 0; k < ids.size(); ++k) {
        FittedParameter& out = fit.parameters.emplace_back();
        out.id = ids[k];
        out.value = fit.model.value(k);
        out.fitted_as = fit.model.fitted_as(k);
        std::tie(out.lower, out.upper) = fit.model.bounds(k);
        out.is_error = fit.model.is_error(k);
        out.is_at_bound = !out.is_error && (is_near(out, out.lower) || is_near(out, out.upper));
        if (k < fit.model.parameters.size()) {
            const FreeParameter& described = fit.model.parameters[k];
            out.unit = described.unit;
            out.is_place = described.is_place;
            out.absent = described.absent;
        } else if (!out.is_error) {
            out.unit = "s";
        }
    }
}

void say_bounds(const std::vector<FittedParameter>& parameters, const std::vector<bool>& is_held,
                std::string& reason) {
    for (std::size_t k = 0; k < parameters.size(); ++k)
        if (const FittedParameter& parameter = parameters[k]; parameter.is_at_bound && !is_held[k])
            reason += fmt::format("{}{} is at its bound, {:.6g}{}{}{}", reason.empty() ? "" : "; ",
                                  to_string(parameter.id), parameter.value,
                                  parameter.unit.empty() ? "" : " ", parameter.unit,
                                  parameter.id.in_one_model() == physics::release_time
                                      ? " (time 0 is not the release: state its uncertainty, "
                                        "[release] time_uncertainty_ms, or let the fit begin later "
                                        "with kind = \"moving\" and start_s), or the model "
                                        "lacks an effect (culm diagnose)"
                                      : "");
}

} // namespace

void add_residuals(std::span<const ObservedRecording> measurements, Fit& fit) {
    double sum_of_squares = 0.0;
    for (std::size_t m = 0; m < fit.parts.size(); ++m) {
        RecordingFit& part = fit.parts[m];
        double squares = 0.0;
        for (std::size_t at = 0; at < part.prediction.readings.size(); ++at) {
            part.residuals.push_back(measurements[m].deflections[at] -
                                     part.prediction.readings[at]);
            if (std::isnan(part.residuals.back()))
                continue;
            ++part.readings;
            squares += part.residuals.back() * part.residuals.back();
        }
        part.rmse = std::sqrt(squares / double(std::max<std::size_t>(part.readings, 1)));
        fit.readings += part.readings;
        sum_of_squares += squares;
    }
    fit.rmse = std::sqrt(sum_of_squares / double(std::max<std::size_t>(fit.readings, 1)));
}

void add_parameters(const JointLayout& layout, const std::vector<bool>& is_held, Fit& fit) {
    for (RecordingFit& part : fit.parts)
        add_part_parameters(part);
    for (std::size_t k = 0; k < layout.ids.size(); ++k) {
        const auto [model, parameter] = layout.owners[k];
        fit.parameters.push_back(fit.parts[model].parameters[parameter]);
        fit.parameters.back().id = layout.ids[k];
    }
    say_bounds(fit.parameters, is_held, fit.reason);
}

} // namespace culm::fit
