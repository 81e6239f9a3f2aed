// SPDX-License-Identifier: BSD-3-Clause
#include "diagnose/fit_summary.hpp"

#include "calibrate/joint_layout.hpp"
#include "core/error.hpp"
#include "diagnose/residual_correlation.hpp"
#include "diagnose/residual_table.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <nlohmann/json.hpp>

namespace culm::diagnose {
namespace {

using nlohmann::json;

/// JSON has no infinity.
json number(double value) {
    return std::isfinite(value) ? json(value) : json(nullptr);
}

double number_from(const json& value) {
    return value.is_null() ? std::numeric_limits<double>::infinity() : value.get<double>();
}

json parameter_json(const calibrate::FittedParameter& parameter) {
    return {parameter.name,        parameter.unit,
            parameter.value,       number(parameter.standard_error),
            parameter.is_at_bound, parameter.lower,
            parameter.upper,       static_cast<int>(parameter.fitted_as),
            parameter.is_place,    parameter.absent};
}

calibrate::FittedParameter parameter_from(const json& told) {
    return {told[0], told[1], told[2], number_from(told[3]),
            told[4], told[5], told[6], static_cast<physics::FittedAs>(told[7].get<int>()),
            told[8], told[9]};
}

/// The models with the numbers that `summary` has for them.
void set_values(const FitSummary& summary, const calibrate::JointLayout& layout,
                std::vector<calibrate::StemModel>& models) {
    for (std::size_t m = 0; m < models.size(); ++m) {
        const std::vector<std::string> names = models[m].free_names();
        for (std::size_t k = 0; k < names.size(); ++k) {
            const calibrate::JointLayout::Share& share = layout.shares[m][k];
            const auto told = std::ranges::find(summary.parameters, layout.names[share.place],
                                                &calibrate::FittedParameter::name);
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

FitSummary summary_of(const ModelFit& fit) {
    FitSummary out{fit.names,      fit.failure,     fit.moves,
                   fit.parameters, fit.chi_squared, fit.reduced_chi_squared,
                   fit.rmse,       fit.readings,    0.0,
                   fit.runs,       fit.out_of_reach};
    for (const calibrate::ChainFit& part : fit.parts)
        out.effective_readings += effective_readings(whitened_residuals(part));
    if (!fit.is_fitted() && out.failure.empty())
        out.failure = "there is no fit";
    return out;
}

std::string to_text(const FitSummary& summary) {
    json parameters = json::array();
    for (const calibrate::FittedParameter& parameter : summary.parameters)
        parameters.push_back(parameter_json(parameter));
    return json{summary.names,
                summary.failure,
                summary.moves,
                std::move(parameters),
                summary.chi_squared,
                summary.reduced_chi_squared,
                summary.rmse,
                summary.readings,
                summary.effective_readings,
                summary.runs,
                summary.out_of_reach ? json(*summary.out_of_reach) : json()}
        .dump();
}

FitSummary summary_from_text(const std::string& text) {
    FitSummary out;
    if (text.empty()) {
        out.failure = "the rank that computed it was lost";
        return out;
    }
    const json told = json::parse(text);
    out.names = told[0].get<std::vector<std::string>>();
    out.failure = told[1];
    out.moves = told[2];
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
    return out;
}

std::vector<calibrate::StemModel> models_of(const FitSummary& summary,
                                            const SelectedEffects& effects,
                                            std::span<const measure::Measurement> recordings,
                                            const CandidateOptions& options) {
    std::vector<calibrate::StemModel> models;
    for (const measure::Measurement& recording : recordings)
        models.push_back(candidate_model(calibrate::baseline_model(recording, options.chain),
                                         effects, recording));
    set_values(summary, calibrate::joint_layout(models, recordings, belongs_to_recording), models);
    return models;
}

ModelFit restored(const FitSummary& summary, const SelectedEffects& effects,
                  std::span<const measure::Measurement> recordings,
                  const CandidateOptions& options) {
    ModelFit out;
    out.names = summary.names;
    out.parameters = summary.parameters;
    out.chi_squared = summary.chi_squared;
    out.reduced_chi_squared = summary.reduced_chi_squared;
    out.rmse = summary.rmse;
    out.readings = summary.readings;
    out.runs = static_cast<int>(recordings.size());
    const std::vector<calibrate::StemModel> models =
        models_of(summary, effects, recordings, options);
    const calibrate::JointLayout layout =
        calibrate::joint_layout(models, recordings, belongs_to_recording);
    calibrate::ChainFitOptions at_once;
    at_once.window = options.window;
    at_once.heartbeat = options.heartbeat;
    for (std::size_t m = 0; m < models.size(); ++m) {
        out.parts.push_back(calibrate::fit_chain_with_held(
            models[m], recordings[m], std::vector<bool>(models[m].free_count(), true), at_once));
        std::vector<std::size_t>& places = out.places.emplace_back();
        for (std::size_t k = 0; k < layout.shares[m].size(); ++k) {
            const calibrate::JointLayout::Share& share = layout.shares[m][k];
            const auto told = std::ranges::find(out.parameters, layout.names[share.place],
                                                &calibrate::FittedParameter::name);
            places.push_back(static_cast<std::size_t>(told - out.parameters.begin()));
            if (told == out.parameters.end())
                continue;
            calibrate::FittedParameter& own = out.parts[m].parameters[k];
            own.standard_error = share.factor * told->standard_error;
            own.is_at_bound = told->is_at_bound;
        }
    }
    return out;
}

} // namespace culm::diagnose
