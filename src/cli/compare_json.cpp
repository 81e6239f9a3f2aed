// SPDX-License-Identifier: BSD-3-Clause
#include "cli/compare_json.hpp"

#include "present/json.hpp"
#include "reduce/distributions.hpp"

#include <algorithm>
#include <cmath>

namespace culm::cli {

using present::number;
namespace {

using nlohmann::json;

json value_json(const fit::FittedParameter& parameter) {
    const double half = reduce::normal_quantile_95 * parameter.standard_error;
    return {{"value", number(parameter.value)},
            {"stderr", number(parameter.standard_error)},
            {"interval", {number(parameter.value - half), number(parameter.value + half)}},
            {"at_bound", parameter.is_at_bound}};
}

json held_out_part(const diagnose::HeldOutPart& part) {
    if (!part.failure.empty())
        return {{"failure", part.failure}};
    return {{"rms_mm", number(1e3 * part.rms)}, {"rms_over_noise", number(part.over_noise)}};
}

json tests_json(const diagnose::Verdict& verdict) {
    json tests = json::array();
    for (const calibrate::LackOfFitTest& test : verdict.tests)
        tests.push_back({{"name", test.name},
                         {"p_value", number(test.p_value)},
                         {"adjusted_p_value", number(test.adjusted_p_value)}});
    return tests;
}

json verdict_json(const diagnose::Verdict& verdict) {
    return {{"finding", diagnose::to_string(verdict.finding)},
            {"adequate", verdict.finding == diagnose::Finding::Adequate},
            {"p_value", number(verdict.p_value)},
            {"reason", verdict.reason},
            {"tests", tests_json(verdict)}};
}

json fit_json_of(const fit::RecordingFit& fit, const diagnose::Comparison& comparison) {
    return {
        {"rmse_mm", number(1e3 * fit.rmse)},
        {"rmse_over_noise", number(fit.rmse / comparison.verdict.noise)},
        {"reduced_chi2", number(fit.reduced_chi_squared)},
        {"degrees_of_freedom", fit.degrees_of_freedom},
        {"effective_degrees_of_freedom", number(comparison.verdict.effective_degrees_of_freedom)},
        {"parameters", parameters_json(fit.parameters)},
        {"verdict", verdict_json(comparison.verdict)},
        {"sentences", diagnose::in_words(comparison)},
        {"where", where_json(comparison, fit)},
        {"remarks", fit.model.remarks}};
}

json rung_json(const diagnose::Ladder& ladder, std::size_t k,
               const measure::Measurement& measurement) {
    const diagnose::Rung& rung = ladder.rungs[k];
    json out{{"model", rung.fit.names},
             {"added", rung.added},
             {"runs", rung.fit.runs},
             {"starts", rung.fit.starts}};
    if (k > 0) {
        out["compared_with"] = rung.compared_with;
        out["gain"] = rung.is_gain;
        out["why"] = rung.why;
    }
    if (rung.fit.failed()) {
        out["failure"] = rung.fit.reason;
        return out;
    }
    out.update(fit_json_of(rung.fit.parts.front(), ladder.comparisons[*ladder.comparison[k]]));
    out["moves"] = rung.fit.moves();
    out["bic"] = number(rung.bic);
    if (k > 0) {
        out["delta_bic"] = number(rung.delta_bic);
        out["change"] = {{"bond_youngs_modulus", number(rung.modulus_change)},
                         {"bond_damping", number(rung.damping_change)}};
    }
    out["held_out"] = {{"last_third", held_out_part(rung.held_out->last_third)},
                       {"one_height", held_out_part(rung.held_out->one_height)}};
    out["held_out"]["one_height"]["height_mm"] = 1e3 * measurement.heights[ladder.left_out_row];
    return out;
}

} // namespace

std::string parameter_key(const fit::FittedParameter& parameter) {
    const std::size_t at = std::min(parameter.name.find('@'), parameter.name.size());
    std::string key = parameter.name.substr(0, at);
    if (key.find('.') == std::string::npos && !parameter.unit.empty())
        key += parameter.unit == "Pa" ? "_pa" : "_" + parameter.unit;
    return key + parameter.name.substr(at);
}

json parameters_json(const std::vector<fit::FittedParameter>& parameters) {
    json out = json::object();
    for (const fit::FittedParameter& parameter : parameters)
        out[parameter_key(parameter)] = value_json(parameter);
    return out;
}

json ladder_json(const diagnose::Ladder& ladder, const measure::Measurement& measurement) {
    json rungs = json::array();
    for (std::size_t k = 0; k < ladder.rungs.size(); ++k)
        rungs.push_back(rung_json(ladder, k, measurement));
    json out{{"format", "culm-comparison"},
             {"version", 1},
             {"measurement", measurement.stem.id},
             {"frames", measurement.times.size()},
             {"heights", measurement.heights.size()},
             {"effective_readings", number(ladder.effective_readings)},
             {"ladder", std::move(rungs)},
             {"remarks", measurement.remarks}};
    for (const diagnose::Rung& rung : ladder.rungs)
        if (!rung.fit.failed()) {
            out["noise_mm"] = number(1e3 * fit::typical_noise(rung.fit.parts.front()));
            out["noise_source"] = rung.fit.parts.front().noise_source;
            out["noise_known"] = rung.fit.parts.front().is_noise_known;
        }
    return out;
}

json cell_json(const diagnose::EffectCell& cell) {
    json out{{"applies", cell.applies}, {"runs", cell.runs}};
    if (!cell.failure.empty()) {
        out["failure"] = cell.failure;
        return out;
    }
    out["rmse_mm"] = number(1e3 * cell.rmse);
    out["rmse_over_noise"] = number(cell.over_noise);
    out["reduced_chi2"] = number(cell.reduced_chi_squared);
    out["parameters"] = parameters_json(cell.parameters);
    out["at_bound"] = cell.is_at_bound;
    return out;
}

} // namespace culm::cli
