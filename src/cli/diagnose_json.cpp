// SPDX-License-Identifier: BSD-3-Clause
#include "cli/diagnose_json.hpp"

#include "cli/compare_json.hpp"
#include "diagnose/comparison.hpp"
#include "fit/solve/residual_statistics.hpp"
#include "present/json.hpp"
#include "present/text.hpp"

#include <cmath>
#include <string>
#include <vector>

#include <fmt/format.h>

namespace culm::cli {

using present::number;
namespace {

using nlohmann::json;

constexpr double millimetres = 1e3;

json parameters_with_units(const std::vector<fit::FittedParameter>& parameters) {
    json out = parameters_json(parameters);
    for (const fit::FittedParameter& parameter : parameters)
        out[parameter_key(parameter)]["unit"] = parameter.unit;
    return out;
}

/// The fit whose residuals are nearest to noise.
const fit::Fit& best_fit(const diagnose::Diagnosis& diagnosis) {
    return !diagnosis.final_fit.failed() ? diagnosis.final_fit : diagnosis.baseline;
}

json recordings_json(const fit::Fit& fit, std::span<const measure::Measurement> recordings) {
    json out = json::array();
    for (std::size_t k = 0; k < recordings.size(); ++k) {
        json recording{{"id", recordings[k].stem.id},
                       {"frames", recordings[k].times.size()},
                       {"heights", recordings[k].heights.size()}};
        if (k < fit.parts.size()) {
            recording["noise_mm"] = number(millimetres * fit::typical_noise(fit.parts[k]));
            recording["noise_source"] = fit.parts[k].noise_source;
            recording["noise_known"] = fit.parts[k].is_noise_known;
        }
        out.push_back(std::move(recording));
    }
    return out;
}

/// Root mean square over the recordings.
json noise_of(const fit::Fit& fit) {
    double sum = 0.0;
    for (const fit::RecordingFit& part : fit.parts)
        sum += std::pow(fit::typical_noise(part), 2);
    return number(millimetres * std::sqrt(sum / static_cast<double>(fit.parts.size())));
}

json baseline_json(const diagnose::Diagnosis& diagnosis) {
    const fit::Fit& fit = diagnosis.baseline;
    return {{"rmse_mm", number(millimetres * fit.rmse)},
            {"reduced_chi2", number(fit.reduced_chi_squared)},
            {"adequate", !diagnosis.ladder.empty() &&
                             diagnosis.ladder.front().finding == diagnose::Finding::Adequate},
            {"parameters", parameters_with_units(fit.parameters)}};
}

std::string summary_of(const std::string& effect, const fit::SelectedEffects& candidates) {
    for (const physics::SelectedEffect& candidate : candidates)
        if (candidate.effect->name() == effect)
            return candidate.effect->summary();
    return {};
}

json ranking_json(const diagnose::Diagnosis& diagnosis, const fit::SelectedEffects& candidates) {
    json out = json::array();
    for (const diagnose::RankedEffect& ranked : diagnosis.ranking) {
        json entry{{"effect", ranked.effect},
                   {"summary", summary_of(ranked.effect, candidates)},
                   {"signature", ranked.signature},
                   {"refitted", ranked.is_refitted},
                   {"ended_early", ranked.fit.out_of_reach.has_value()},
                   {"rmse_mm", number(millimetres * ranked.rmse)},
                   {"delta_bic", number(ranked.delta_bic)},
                   {"p_value", number(ranked.p_value)},
                   {"parameters", parameters_with_units(ranked.fit.parameters)},
                   {"obstacle", ranked.obstacle},
                   {"looks_like", ranked.looks_like}};
        if (ranked.is_refitted && ranked.fit.failed()) {
            entry["failure"] = ranked.fit.reason;
            for (const char* key : {"rmse_mm", "delta_bic", "p_value"})
                entry[key] = nullptr;
        }
        out.push_back(std::move(entry));
    }
    return out;
}

/// Candidates without a fit, and those without even a score, which alone have an obstacle but no
/// fit.
json failed_json(const std::vector<diagnose::RankedEffect>& ranking) {
    json out = json::array();
    for (const diagnose::RankedEffect& ranked : ranking) {
        const std::string& reason = ranked.is_refitted && ranked.fit.failed() ? ranked.fit.reason
                                    : ranked.is_refitted                      ? std::string()
                                                                              : ranked.obstacle;
        if (!reason.empty())
            out.push_back({{"effect", ranked.effect}, {"reason", reason}});
    }
    return out;
}

json ladder_of(const std::vector<diagnose::DiagnosisRung>& ladder) {
    json out = json::array();
    for (const diagnose::DiagnosisRung& rung : ladder) {
        json entry{{"model", rung.fit.names},
                   {"rmse_mm", number(millimetres * rung.fit.rmse)},
                   {"reduced_chi2", number(rung.fit.reduced_chi_squared)},
                   {"finding", diagnose::to_string(rung.finding)},
                   {"p_value", number(rung.p_value)},
                   {"tests", rung.tests},
                   {"parameters", parameters_with_units(rung.fit.parameters)}};
        if (!out.empty()) {
            entry["delta_bic"] = number(rung.delta_bic);
            const bool is_computed = rung.held_out > 0.0;
            entry["held_out_over_noise"] = is_computed ? number(rung.held_out) : json();
            entry["held_out_before_over_noise"] =
                is_computed ? number(rung.held_out_before) : json();
        }
        out.push_back(std::move(entry));
    }
    return out;
}

/// What a small effect, if it were there, would do to the calibration.
std::string bias_in_words(const diagnose::EffectScore& score) {
    return fmt::format("at that size the calibrated Y would be off by {} and beta by {}",
                       present::percent_text(score.youngs_modulus_bias),
                       present::percent_text(score.damping_bias));
}

json blind_spots_json(const std::vector<diagnose::EffectScore>& scores) {
    json out = json::array();
    for (const diagnose::EffectScore& score : scores) {
        json entry{{"effect", score.effect}};
        if (!score.failure.empty()) {
            entry["failure"] = score.failure;
        } else {
            entry["smallest_visible"] = {{"parameter", score.parameter},
                                         {"value", number(score.smallest_visible)},
                                         {"unit", score.unit}};
            entry["beyond_bounds"] = score.is_beyond_bounds;
            entry["bias_if_present"] = bias_in_words(score);
            entry["bias"] = {{"bond_youngs_modulus", number(score.youngs_modulus_bias)},
                             {"bond_damping", number(score.damping_bias)}};
        }
        out.push_back(std::move(entry));
    }
    return out;
}

json experiments_json(const std::vector<diagnose::Experiment>& experiments) {
    json out = json::array();
    for (const diagnose::Experiment& experiment : experiments) {
        json pairs = json::array();
        for (const auto& [one, other] : experiment.separates)
            pairs.push_back({one, other});
        out.push_back({{"what", experiment.what},
                       {"separates", std::move(pairs)},
                       {"expected_gap", number(experiment.expected_gap)}});
    }
    return out;
}

json samples_json(const std::vector<diagnose::ForceSample>& samples, const char* key) {
    json out = json::array();
    for (const diagnose::ForceSample& sample : samples)
        out.push_back({{"displacement_mm", number(millimetres * sample.displacement)},
                       {"velocity_m_s", number(sample.velocity)},
                       {key, number(sample.force)}});
    return out;
}

json missing_force_json(const diagnose::MissingForce& force) {
    const char* key = force.kind == "bending_moment" ? "moment_n_m" : "force_n_per_m";
    json terms = json::array();
    for (const diagnose::ForceTerm& term : force.terms)
        terms.push_back({{"term", term.term},
                         {"coefficient", number(term.coefficient)},
                         {"stderr", number(term.standard_error)},
                         {"stability", number(term.stability)}});
    return {{"kind", force.kind},
            {"form", force.form},
            {"character", force.character},
            {"terms", std::move(terms)},
            {"explained", number(force.explained)},
            {"rmse_mm", force.fit.is_fitted() ? number(millimetres * force.fit.rmse) : json()},
            {"against_displacement", samples_json(force.against_displacement, key)},
            {"against_velocity", samples_json(force.against_velocity, key)},
            {"effect_file", force.as_effect_file}};
}

/// One of the windows' numbers against the amplitude, measured and modelled.
json against_amplitude(const json& windows, const char* quantity) {
    json out = json::array();
    for (const json& window : windows) {
        if (window["measured"].is_null())
            continue;
        out.push_back(
            {{"amplitude_mm", window["measured"]["amplitude_mm"]},
             {"measured", window["measured"][quantity]},
             {"modelled", window["modelled"].is_null() ? json() : window["modelled"][quantity]}});
    }
    return out;
}

json where_of(const fit::Fit& fit, std::size_t part, const measure::Measurement& recording) {
    fit::Fit candidate;
    candidate.names = fit.names;
    candidate.status = fit.status;
    candidate.parts = {fit.parts[part]};
    json where = where_json(diagnose::compare(candidate, recording), fit.parts[part]);
    where["frequency_vs_amplitude"] = against_amplitude(where["against_amplitude"], "frequency_hz");
    where["decay_vs_amplitude"] = against_amplitude(where["against_amplitude"], "b1_per_cycle");
    return where;
}

void add_ties(const std::vector<diagnose::TieGroup>& ties, json& document) {
    for (const char* key : {"ties", "ties_separate_by", "ties_delta_bic"})
        document[key] = json::array();
    for (const diagnose::TieGroup& tie : ties) {
        json gaps = json::array();
        for (const double gap : tie.delta_bic)
            gaps.push_back(number(gap));
        document["ties"].push_back(tie.names);
        document["ties_separate_by"].push_back(tie.separate_by);
        document["ties_delta_bic"].push_back(std::move(gaps));
    }
}

void add_recordings(const fit::Fit& fit, std::span<const measure::Measurement> recordings,
                    json& document) {
    std::string id;
    std::vector<std::string> ids;
    json remarks = json::array();
    for (const measure::Measurement& recording : recordings) {
        if (!id.empty())
            id += '+';
        id += recording.stem.id;
        ids.push_back(recording.stem.id);
        for (const std::string& remark : recording.remarks)
            remarks.push_back(remark);
    }
    document["measurement"] = id;
    if (recordings.size() > 1)
        document["measurements"] = ids;
    document["recordings"] = recordings_json(fit, recordings);
    document["noise_mm"] = noise_of(fit);
    document["remarks"] = std::move(remarks);
    document["where"] = where_of(fit, 0, recordings.front());
    if (recordings.size() > 1) {
        document["where_by_recording"] = json::array();
        for (std::size_t k = 0; k < fit.parts.size(); ++k)
            document["where_by_recording"].push_back(where_of(fit, k, recordings[k]));
    }
}

/// Numbers of the best model; of one that leaves structure, those that count it as correlated
/// noise.
void add_numbers(const diagnose::Diagnosis& diagnosis,
                 std::span<const measure::Measurement> recordings, json& document) {
    const json counted = parameters_with_units(best_fit(diagnosis).parameters);
    document["parameters"] = counted;
    document["correlated_misses"] = nullptr;
    if (!diagnosis.correlated)
        return;
    document["parameters"] = parameters_with_units(diagnosis.correlated->parameters);
    json& misses = document["correlated_misses"] = {{"least_squares", counted}};
    for (std::size_t m = 0; m < recordings.size(); ++m)
        misses["correlation"].push_back(
            {{"recording", recordings[m].stem.id}, {"rows", diagnosis.correlated->correlation[m]}});
}

} // namespace

json diagnosis_json(const diagnose::Diagnosis& diagnosis,
                    std::span<const measure::Measurement> recordings,
                    const fit::SelectedEffects& candidates) {
    json document{{"format", "culm-diagnosis"},
                  {"version", 1},
                  {"verdict", diagnose::to_string(diagnosis.conclusion)},
                  {"reason", diagnosis.reason},
                  {"effects", diagnosis.effects},
                  {"explained", number(diagnosis.explained)},
                  {"baseline", baseline_json(diagnosis)},
                  {"ranking", ranking_json(diagnosis, candidates)},
                  {"ladder", ladder_of(diagnosis.ladder)},
                  {"blind_spots", blind_spots_json(diagnosis.blind_spots)},
                  {"next_experiment", experiments_json(diagnosis.next_experiments)},
                  {"false_naming_rate", number(diagnosis.false_naming.rate)},
                  {"false_naming",
                   {{"rate", number(diagnosis.false_naming.rate)},
                    {"upper_bound", number(diagnosis.false_naming.upper_bound)},
                    {"draws", diagnosis.false_naming.draws}}},
                  {"missing_force",
                   diagnosis.missing_force ? missing_force_json(*diagnosis.missing_force) : json()},
                  {"runs", diagnosis.runs}};
    add_numbers(diagnosis, recordings, document);
    document["failed"] = failed_json(diagnosis.ranking);
    add_ties(diagnosis.ties, document);
    add_recordings(best_fit(diagnosis), recordings, document);
    return document;
}

} // namespace culm::cli
