// SPDX-License-Identifier: BSD-3-Clause
#include "diagnose/policy.hpp"
#include "fit/solve/residual_statistics.hpp"
#include "present/comparison.hpp"
#include "present/diagnosis.hpp"
#include "present/files.hpp"
#include "present/laboratory.hpp"
#include "present/parameters.hpp"
#include "present/text.hpp"

#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace culm::present {
namespace {

using nlohmann::json;

constexpr double least_listed = 1e-3; ///< probability of an explanation

json parameters_with_units(std::span<const fit::FittedParameter> parameters) {
    json out = parameters_json(parameters);
    for (const fit::FittedParameter& parameter : parameters)
        if (!parameter.is_error)
            out[parameter_key(parameter)]["unit"] = parameter.unit;
    return out;
}

/// The noise is that of the fit's weights: stated, measured, or estimated from the residuals.
json recordings_json(const fit::Fit& fit, std::span<const measure::Measurement> recordings) {
    json out = json::array();
    for (std::size_t k = 0; k < recordings.size(); ++k) {
        json recording{{"id", recordings[k].stem.id},
                       {"frames", recordings[k].times.size()},
                       {"heights", recordings[k].heights.size()}};
        if (k < fit.parts.size()) {
            recording["noise_mm"] = number(1e3 * fit::typical_noise(fit.parts[k]));
            recording["noise_source"] = fit.parts[k].noise_source;
            recording["noise_known"] = fit.parts[k].is_noise_known;
        }
        out.push_back(std::move(recording));
    }
    return out;
}

json baseline_json(const diagnose::Diagnosis& diagnosis) {
    const fit::Fit& fit = diagnosis.baseline;
    return {{"rmse_mm", number(1e3 * fit.rmse)},
            {"reduced_chi2", number(fit.reduced_chi_squared)},
            {"adequate", !diagnosis.ladder.empty() && diagnosis.ladder.front().verdict.finding ==
                                                          diagnose::Finding::Adequate},
            {"parameters", parameters_with_units(fit.parameters)}};
}

json failed_json(const std::vector<diagnose::ModelProbability>& models) {
    json out = json::array();
    for (const diagnose::ModelProbability& model : models)
        if (!model.failure.empty())
            out.push_back({{"effects", effect_names(model.effects)}, {"reason", model.failure}});
    return out;
}

json models_json(const std::vector<diagnose::SearchedModel>& ladder) {
    json out = json::array();
    for (const diagnose::SearchedModel& model : ladder) {
        json entry{{"model", model.fit.names()},
                   {"rmse_mm", number(1e3 * model.fit.rmse)},
                   {"reduced_chi2", number(model.fit.reduced_chi_squared)},
                   {"contradicted_inputs", contradictions_json(model.fit.pulls)},
                   {"finding", diagnose::to_string(model.verdict.finding)},
                   {"finding_text", finding_text(model.verdict.finding)},
                   {"p_value", number(model.verdict.p_value)},
                   {"tests", model.verdict.reason},
                   {"parameters", parameters_with_units(model.fit.parameters)}};
        if (!out.empty())
            entry["log_evidence"] = number(model.log_evidence);
        out.push_back(std::move(entry));
    }
    return out;
}

/// The bias of the calibration by an effect at its detection limit.
std::string bias_text(const diagnose::DetectionLimit& score) {
    return fmt::format("at that size the calibrated Y would be off by {} and beta by {}",
                       present::percent_text(score.youngs_modulus_bias),
                       present::percent_text(score.damping_bias));
}

json blind_spots_json(const std::vector<diagnose::DetectionLimit>& scores) {
    json out = json::array();
    for (const diagnose::DetectionLimit& score : scores) {
        json entry{{"effect", score.effect}};
        if (!score.failure.empty()) {
            entry["failure"] = score.failure;
        } else {
            entry["smallest_visible"] = {{"parameter", score.parameter},
                                         {"value", number(score.value)},
                                         {"unit", score.unit}};
            entry["beyond_bounds"] = score.is_beyond_bounds;
            entry["bias_if_present"] = bias_text(score);
            entry["bias"] = {{"bond_youngs_modulus", number(score.youngs_modulus_bias)},
                             {"bond_damping", number(score.damping_bias)}};
        }
        out.push_back(std::move(entry));
    }
    return out;
}

json experiments_json(const std::vector<diagnose::Experiment>& experiments) {
    return array_of(experiments, [](const diagnose::Experiment& experiment) -> json {
        return {{"what", experiment.what},
                {"separates", {experiment.first_model, experiment.second_model}},
                {"expected_gap", number(experiment.expected_gap)}};
    });
}

/// The force at the tip along one axis of its phase plane.
json samples_json(const std::vector<diagnose::ForceSample>& samples, const char* key) {
    return array_of(samples, [key](const diagnose::ForceSample& sample) -> json {
        return {{"displacement_mm", number(1e3 * sample.displacement)},
                {"velocity_m_s", number(sample.velocity)},
                {key, number(sample.force)}};
    });
}

json missing_force_json(const diagnose::MissingForce& force) {
    const char* key = force.kind == "bending_moment" ? "moment_n_m" : "force_n_per_m";
    const auto term_json = [](const diagnose::ForceTerm& term) -> json {
        return {{"term", term.term},
                {"coefficient", number(term.coefficient)},
                {"stderr", number(term.standard_error)},
                {"probability", number(term.probability)}};
    };
    return {{"kind", force.kind},
            {"form", force.form},
            {"character", force.character},
            {"terms", array_of(force.terms, term_json)},
            {"explained", number(force.explained)},
            {"rmse_mm", force.fit.is_fitted() ? number(1e3 * force.fit.rmse) : json()},
            {"against_displacement", samples_json(force.against_displacement, key)},
            {"against_velocity", samples_json(force.against_velocity, key)},
            {"effect_file", force.as_effect_file}};
}

/// The residuals of one recording of a joint fit, as `culm compare` reports them.
json where_of(const DiagnosisReport& report, std::size_t part) {
    fit::Fit fit = report.best_fit();
    fit.parts = std::vector{fit.parts[part]};
    const diagnose::Comparison comparison =
        diagnose::compare(fit, report.recordings[part], report.found.policy);
    json where = where_json(comparison, fit.parts.front());
    where["frequency_vs_amplitude"] =
        against_amplitude_json(comparison.windows, &residuals::WindowFit::frequency);
    where["decay_vs_amplitude"] =
        against_amplitude_json(comparison.windows, &residuals::WindowFit::decay_per_cycle);
    return where;
}

json largest_unvisited_json(const std::optional<diagnose::UnvisitedModel>& model) {
    if (!model)
        return nullptr;
    return {{"effects", effect_names(diagnose::added_names(model->effects))},
            {"log_evidence", number(model->log_evidence)}};
}

void add_recordings(const DiagnosisReport& report, json& document) {
    std::vector<std::string> ids;
    json remarks = json::array();
    json wheres = json::array();
    for (std::size_t k = 0; k < report.recordings.size(); ++k) {
        const measure::Measurement& recording = report.recordings[k];
        ids.push_back(recording.stem.id);
        for (const std::string& remark : recording.remarks)
            remarks.push_back(remark);
        wheres.push_back(where_of(report, k));
    }
    document["measurement"] = fmt::format("{}", fmt::join(ids, "+"));
    document["recordings"] = recordings_json(report.best_fit(), report.recordings);
    document["noise_mm"] = number(1e3 * report.noise());
    document["remarks"] = std::move(remarks);
    document["where"] = wheres.front();
    if (report.recordings.size() > 1) {
        document["measurements"] = std::move(ids);
        document["where_by_recording"] = std::move(wheres);
    }
}

json model_json(const diagnose::ModelProbability& model, bool is_one_stem) {
    json out{{"effects", effect_names(model.effects, is_one_stem)},
             {"log_evidence", number(model.log_evidence)},
             {"probability", number(model.probability)}};
    if (!model.failure.empty()) {
        out["failure"] = model.failure;
        out["log_evidence"] = nullptr;
    }
    return out;
}

json families_json(const std::vector<diagnose::NamedFamily>& families) {
    return array_of(families, [](const diagnose::NamedFamily& named) -> json {
        json out{{"family", physics::to_string(named.family)},
                 {"members", named.members},
                 {"by_family", named.is_open}};
        if (!named.rig.empty())
            out["rig"] = named.rig;
        return out;
    });
}

} // namespace

json answer_json(const diagnose::Diagnosis& found) {
    const bool is_one_stem = found.stems.size() == 1;
    json out{{"reason", found.reason},
             {"probability", number(found.probability)},
             {"families", families_json(found.families)},
             {"alternatives", json::array()},
             {"explanations", json::array()},
             {"immaterial", json::array()},
             {"models", json::array()}};
    for (const diagnose::FamilyExplanation& each : found.alternatives)
        out["alternatives"].push_back({{"families", families_json(each.families)},
                                       {"probability", number(each.probability)}});
    for (const diagnose::Explanation& each : found.posterior.explanations)
        if (each.probability >= least_listed)
            out["explanations"].push_back({{"effects", effect_names(each.effects, is_one_stem)},
                                           {"probability", number(each.probability)}});
    for (const diagnose::ImmaterialEffect& each : found.posterior.immaterial)
        out["immaterial"].push_back({{"effect", effect_names({each.effect}, is_one_stem).front()},
                                     {"over_noise", number(each.over_noise)}});
    for (const diagnose::ModelProbability& each : found.posterior.models)
        out["models"].push_back(model_json(each, is_one_stem));
    return out;
}

json diagnosis_json(const DiagnosisReport& report) {
    const diagnose::Diagnosis& found = report.found;
    if (found.stems.size() > 1)
        return laboratory_json(found);
    json document = answer_json(found);
    document.update(
        {{"format", "culm-diagnosis"},
         {"version", 2},
         {"verdict", diagnose::to_string(found.conclusion)},
         {"sentences", diagnosis_sentences(report)},
         {"effects", found.effects},
         {"explained", number(found.explained)},
         {"unexplained_mm", number(1e3 * found.unexplained)},
         {"unexplained_share_of_swing", number(found.unexplained_share)},
         {"baseline", baseline_json(found)},
         {"parameters", parameters_with_units(report.parameters())},
         {"largest_unvisited", largest_unvisited_json(found.largest_unvisited)},
         {"failed", failed_json(found.posterior.models)},
         {"ladder", models_json(found.ladder)},
         {"blind_spots", blind_spots_json(found.blind_spots)},
         {"next_experiment", experiments_json(found.next_experiments)},
         {"missing_force", found.missing_force ? missing_force_json(*found.missing_force) : json()},
         {"runs", found.batches}});
    add_recordings(report, document);
    return document;
}

} // namespace culm::present
