// SPDX-License-Identifier: BSD-3-Clause
#include "fit/fit_numbers.hpp"

#include "core/error.hpp"
#include "fit/solve/layout.hpp"
#include "fit/solve/residual_statistics.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <nlohmann/json.hpp>

namespace culm::fit {
namespace {

using nlohmann::json;

/// JSON has no infinity.
json number(double value) {
    return std::isfinite(value) ? json(value) : json(nullptr);
}

double number_from(const json& value) {
    return value.is_null() ? std::numeric_limits<double>::infinity() : value.get<double>();
}

json parameter_json(const FittedParameter& parameter) {
    return {parameter.name,        parameter.unit,
            parameter.value,       number(parameter.standard_error),
            parameter.is_at_bound, parameter.lower,
            parameter.upper,       static_cast<int>(parameter.fitted_as),
            parameter.is_place,    parameter.absent};
}

FittedParameter parameter_from(const json& told) {
    return {told[0], told[1], told[2], number_from(told[3]),
            told[4], told[5], told[6], static_cast<physics::FittedAs>(told[7].get<int>()),
            told[8], told[9]};
}

/// The models with the numbers that `summary` has for them.
void set_values(const Fit& summary, const JointLayout& layout, std::vector<StemModel>& models) {
    for (std::size_t m = 0; m < models.size(); ++m) {
        const std::vector<std::string> names = models[m].free_names();
        for (std::size_t k = 0; k < names.size(); ++k) {
            const JointLayout::Share& share = layout.shares[m][k];
            const auto told = std::ranges::find(summary.parameters, layout.names[share.place],
                                                &FittedParameter::name);
            if (told == summary.parameters.end())
                continue;
            if (k < models[m].parameters.size())
                models[m].parameters[k].access.set(models[m].spec, share.factor * told->value);
            else
                models[m].release_time = told->value;
        }
    }
}

} // namespace

Fit numbers_of(const Fit& fit) {
    Fit out = fit;
    out.parts.clear();
    out.places.clear();
    out.weights.clear();
    out.covariance.resize(0, 0);
    out.effective_readings = 0.0;
    if (fit.failed() && fit.reason.empty())
        out.reason = "there is no fit";
    for (const RecordingFit& part : fit.parts)
        out.effective_readings += effective_readings(whitened_residuals(part));
    return out;
}

std::string to_text(const Fit& numbers) {
    json parameters = json::array();
    for (const FittedParameter& parameter : numbers.parameters)
        parameters.push_back(parameter_json(parameter));
    json misfits = json::array();
    for (const RecordingMisfit& misfit : numbers.misfits)
        misfits.push_back(
            {misfit.readings, misfit.chi_squared, misfit.rmse, misfit.is_noise_known});
    return json{numbers.names,
                static_cast<int>(numbers.status),
                numbers.reason,
                std::move(parameters),
                numbers.chi_squared,
                numbers.reduced_chi_squared,
                numbers.rmse,
                numbers.readings,
                numbers.effective_readings,
                numbers.runs,
                numbers.out_of_reach ? json(*numbers.out_of_reach) : json(),
                std::move(misfits)}
        .dump();
}

Fit fit_from_text(const std::string& text) {
    Fit out;
    if (text.empty()) {
        out.reason = "the rank that computed it was lost";
        return out;
    }
    const json told = json::parse(text);
    out.names = told[0].get<std::vector<std::string>>();
    out.status = static_cast<FitStatus>(told[1].get<int>());
    out.reason = told[2];
    for (const json& parameter : told[3])
        out.parameters.push_back(parameter_from(parameter));
    out.chi_squared = told[4];
    out.reduced_chi_squared = told[5];
    out.rmse = told[6];
    out.readings = told[7];
    out.effective_readings = told[8];
    out.runs = told[9];
    if (!told[10].is_null())
        out.out_of_reach = told[10].get<double>();
    for (const json& misfit : told[11])
        out.misfits.push_back({misfit[0], misfit[1], misfit[2], misfit[3]});
    return out;
}

std::vector<StemModel> models_of(const Fit& numbers,
                                 std::span<const measure::Measurement> recordings,
                                 const FitOptions& options) {
    std::vector<StemModel> models;
    for (const measure::Measurement& recording : recordings)
        models.push_back(
            candidate_model(baseline_model(recording, options.chain), numbers.effects, recording));
    set_values(numbers, joint_layout(models, recordings, belongs_to_recording), models);
    return models;
}

Fit restored(const Fit& numbers, std::span<const measure::Measurement> recordings,
             const FitOptions& options) {
    Fit out = numbers;
    out.runs = static_cast<int>(recordings.size());
    const std::vector<StemModel> models = models_of(numbers, recordings, options);
    const JointLayout layout = joint_layout(models, recordings, belongs_to_recording);
    SolveOptions at_once;
    at_once.window = options.window;
    at_once.heartbeat = options.heartbeat;
    for (std::size_t m = 0; m < models.size(); ++m) {
        out.parts.push_back(fit_chain_with_held(
            models[m], recordings[m], std::vector<bool>(models[m].free_count(), true), at_once));
        std::vector<std::size_t>& places = out.places.emplace_back();
        for (std::size_t k = 0; k < layout.shares[m].size(); ++k) {
            const JointLayout::Share& share = layout.shares[m][k];
            const auto found = std::ranges::find(out.parameters, layout.names[share.place],
                                                 &FittedParameter::name);
            places.push_back(static_cast<std::size_t>(found - out.parameters.begin()));
            if (found == out.parameters.end())
                continue;
            FittedParameter& own = out.parts[m].parameters[k];
            own.standard_error = share.factor * found->standard_error;
            own.is_at_bound = found->is_at_bound;
        }
    }
    return out;
}

} // namespace culm::fit
