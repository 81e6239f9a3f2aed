// SPDX-License-Identifier: BSD-3-Clause
#include "bench/diagnosis_outcome.hpp"

#include "bench/cpu_time.hpp"
#include "core/error.hpp"

#include <cmath>
#include <span>

namespace culm::bench {
namespace {

double over_noise(const fit::Fit& fit, const measure::Measurement& measurement) {
    return fit.is_fitted() && measurement.noise ? fit.rmse / *measurement.noise : 0.0;
}

} // namespace

Outcome diagnosed(const measure::Measurement& measurement,
                  const diagnose::DiagnosisOptions& options) {
    Outcome outcome;
    const double start = cpu_seconds();
    try {
        const diagnose::Diagnosis found = diagnose::diagnose(std::span(&measurement, 1), options);
        outcome.verdict = diagnose::to_string(found.conclusion);
        outcome.reason = found.reason;
        outcome.effects = found.effects;
        for (const diagnose::NamedFamily& named : found.families)
            outcome.families.push_back({std::string(to_string(named.family)), named.members});
        outcome.ties = ties_of(found);
        for (const fit::FittedParameter& parameter : found.final_fit.parameters)
            outcome.parameters.push_back(
                {to_string(parameter.id), parameter.value, parameter.standard_error});
        outcome.baseline_misfit = over_noise(found.baseline, measurement);
        outcome.final_misfit = over_noise(found.final_fit, measurement);
        outcome.runs = found.runs;
    } catch (const core::NumericalError& error) {
        return no_answer(error.what(), cpu_seconds() - start);
    } catch (const core::InputError& error) {
        return no_answer(error.what(), cpu_seconds() - start);
    }
    outcome.seconds = cpu_seconds() - start;
    return outcome;
}

std::vector<std::vector<std::string>> ties_of(const diagnose::Diagnosis& found) {
    std::vector<std::string> others;
    for (std::size_t k = 1; k < found.alternatives.size(); ++k) {
        std::string names;
        for (const diagnose::NamedFamily& named : found.alternatives[k].families)
            for (const std::string& member : named.members)
                names += (names.empty() ? "" : ",") + member;
        others.push_back(names.empty() ? "nothing" : names);
    }
    std::vector<std::vector<std::string>> ties;
    for (const std::string& effect : found.effects)
        if (!others.empty()) {
            ties.push_back({effect});
            ties.back().insert(ties.back().end(), others.begin(), others.end());
        }
    return ties;
}

Outcome no_answer(const std::string& reason, double cpu_s) {
    Outcome outcome;
    outcome.verdict = "failed";
    outcome.reason = reason;
    outcome.seconds = cpu_s;
    return outcome;
}

void to_json(nlohmann::json& json, const Outcome& outcome) {
    nlohmann::json parameters = nlohmann::json::array();
    for (const FoundParameter& parameter : outcome.parameters)
        // JSON has no infinity: an error that the data do not tell is null.
        parameters.push_back({{"name", parameter.name},
                              {"value", parameter.value},
                              {"standard_error", parameter.standard_error}});
    nlohmann::json families = nlohmann::json::array();
    for (const FoundFamily& found : outcome.families)
        families.push_back({{"family", found.family}, {"members", found.members}});
    json = {{"verdict", outcome.verdict},
            {"reason", outcome.reason},
            {"effects", outcome.effects},
            {"families", families},
            {"ties", outcome.ties},
            {"parameters", parameters},
            {"baseline_misfit", outcome.baseline_misfit},
            {"final_misfit", outcome.final_misfit},
            {"runs", outcome.runs},
            {"cpu_s", outcome.seconds}};
}

void from_json(const nlohmann::json& json, Outcome& outcome) {
    json.at("verdict").get_to(outcome.verdict);
    json.at("reason").get_to(outcome.reason);
    json.at("effects").get_to(outcome.effects);
    for (const nlohmann::json& found : json.value("families", nlohmann::json::array()))
        outcome.families.push_back({found.at("family"), found.at("members")});
    json.at("ties").get_to(outcome.ties);
    for (const nlohmann::json& parameter : json.at("parameters")) {
        const nlohmann::json& error = parameter.at("standard_error");
        outcome.parameters.push_back({parameter.at("name"), parameter.at("value"),
                                      error.is_null() ? HUGE_VAL : error.get<double>()});
    }
    json.at("baseline_misfit").get_to(outcome.baseline_misfit);
    json.at("final_misfit").get_to(outcome.final_misfit);
    json.at("runs").get_to(outcome.runs);
    json.at("cpu_s").get_to(outcome.seconds);
}

} // namespace culm::bench
