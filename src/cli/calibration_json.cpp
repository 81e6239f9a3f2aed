// SPDX-License-Identifier: BSD-3-Clause
#include "cli/calibration_json.hpp"

#include "calibrate/population.hpp"
#include "core/error.hpp"
#include "core/nearest_name.hpp"
#include "present/json.hpp"
#include "reduce/distributions.hpp"

#include <cmath>

#include <fmt/format.h>

namespace culm::cli {

using present::number;
namespace {

using nlohmann::json;

json interval(double lower, double upper) {
    return json::array({number(lower), number(upper)});
}

json value_json(double value, double standard_error) {
    return {{"value", number(value)},
            {"stderr", number(standard_error)},
            {"interval", interval(value - reduce::normal_quantile_95 * standard_error,
                                  value + reduce::normal_quantile_95 * standard_error)}};
}

/// bond_youngs_modulus_pa, tip_deflection_m, …; effects' parameters have their unit in their name.
std::string key_of(const fit::FittedParameter& parameter) {
    if (parameter.name.find('.') != std::string::npos || parameter.unit.empty())
        return parameter.name;
    return parameter.name + (parameter.unit == "Pa" ? "_pa" : "_" + parameter.unit);
}

json stem_parameters_json(const calibrate::Calibration& calibration) {
    json out = json::object();
    for (std::size_t k = 0; k < calibration.fit.parameters.size(); ++k) {
        const fit::FittedParameter& parameter = calibration.fit.parameters[k];
        json& entry = out[key_of(parameter)];
        entry = value_json(parameter.value, parameter.standard_error);
        if (k < calibration.profiles.size())
            entry["profile_interval"] =
                interval(calibration.profiles[k].lower, calibration.profiles[k].upper);
    }
    return out;
}

json correlation_json(const fit::RecordingFit& fit) {
    json names = json::array();
    json rows = json::array();
    for (Eigen::Index a = 0; a < fit.correlation.rows(); ++a) {
        names.push_back(key_of(fit.parameters[static_cast<std::size_t>(a)]));
        json row = json::array();
        for (Eigen::Index b = 0; b < fit.correlation.cols(); ++b)
            row.push_back(number(fit.correlation(a, b)));
        rows.push_back(row);
    }
    return {{"names", names}, {"matrix", rows}};
}

json chain_json(const fit::RecordingFit& fit, const std::string& law) {
    const physics::StemParameters<double>& stem = fit.model.spec.stem;
    json effects = json::array();
    for (const physics::ActiveEffect& active : fit.model.spec.effects) {
        json values = json::object();
        const auto parameters = active.effect->parameters();
        for (std::size_t k = 0; k < parameters.size(); ++k)
            values[parameters[k].name] = number(active.values[k]);
        effects.push_back({{"name", active.effect->name()}, {"values", values}});
    }
    json masses = json::array();
    for (const run::PointMass& mass : fit.model.spec.added_masses)
        masses.push_back({{"height_m", mass.height}, {"mass_kg", mass.mass}});
    return {{"law", law},
            {"spheres", stem.sphere_count},
            {"bond_length_m", stem.bond_length},
            {"sphere_diameter_m", stem.sphere_diameter},
            {"sphere_density_kg_m3", stem.density},
            {"tip_mass_share", stem.tip_mass_share},
            {"bond_outer_diameter_m", stem.bond_outer_diameter},
            {"bond_inner_diameter_m", stem.bond_inner_diameter},
            {"poissons_ratio", stem.poissons_ratio},
            {"added_masses", masses},
            {"effects", effects}};
}

json fit_quality_json(const calibrate::Calibration& calibration) {
    const fit::RecordingFit& fit = calibration.fit;
    json tests = json::array();
    for (const calibrate::LackOfFitTest& test : calibration.lack_of_fit.tests)
        tests.push_back({{"name", test.name},
                         {"p_value", number(test.p_value)},
                         {"adjusted_p_value", number(test.adjusted_p_value)}});
    double noise = 0.0;
    for (const double row : fit.noise)
        noise += row * row / static_cast<double>(fit.noise.size());
    return {{"rmse_mm", 1e3 * fit.rmse},
            {"noise_mm", 1e3 * std::sqrt(noise)},
            {"noise_source", fit.noise_source},
            {"reduced_chi2", number(fit.reduced_chi_squared)},
            {"degrees_of_freedom", fit.degrees_of_freedom},
            {"readings", fit.readings},
            {"runs", fit.runs},
            {"adequate", calibration.lack_of_fit.is_adequate},
            {"reason", calibration.lack_of_fit.reason},
            {"tests", tests}};
}

json mode_json(const calibrate::Calibration& calibration) {
    const fit::FittedParameter* modulus = calibration.fit.find("bond_youngs_modulus");
    const fit::FittedParameter* damping = calibration.fit.find("bond_damping");
    const integrate::VibrationMode& mode = calibration.mode;
    // b2 goes with √Y and b1 per cycle with β, up to the square of the damping ratio.
    return {{"b2_hz", value_json(mode.frequency,
                                 0.5 * mode.frequency * modulus->standard_error / modulus->value)},
            {"b1_per_cycle",
             value_json(mode.decay_per_cycle,
                        std::abs(mode.decay_per_cycle) * damping->standard_error / damping->value)},
            {"natural_frequency_hz", mode.natural_frequency()},
            {"damping_ratio", mode.damping_ratio()},
            {"damping_time_s", calibration.damping_time}};
}

json check_json(const calibrate::Calibration& calibration) {
    if (!calibration.check)
        return {{"failure", calibration.check_failure}};
    const calibrate::CalibrationCheck& check = *calibration.check;
    return {{"measured_b1_per_cycle", check.measured_decay_per_cycle},
            {"simulated_b1_per_cycle", check.simulated_decay_per_cycle},
            {"b1_error_percent", 100.0 * check.decay_error},
            {"b1_resolution_percent", 100.0 * check.decay_resolution},
            {"measured_b2_hz", check.measured_frequency},
            {"simulated_b2_hz", check.simulated_frequency},
            {"b2_error_percent", 100.0 * check.frequency_error},
            {"b2_resolution_percent", 100.0 * check.frequency_resolution}};
}

json prediction_json(const std::optional<reduce::Prediction>& found) {
    if (!found)
        return nullptr;
    return {{"value", number(found->value)},
            {"stderr", number(found->standard_error)},
            {"interval", interval(found->lower, found->upper)}};
}

json central_range_json(const std::vector<double>& values) {
    const calibrate::CentralRange found = calibrate::central_range(values);
    return {{"mean", found.sample.mean},
            {"standard_deviation", number(found.sample.standard_deviation)},
            {"median", found.sample.median},
            {"lowest", found.sample.lowest},
            {"highest", found.sample.highest},
            {"central_90_percent", interval(found.range.lower, found.range.upper)},
            {"central_90_percent_lower_interval",
             interval(found.lower_interval.lower, found.lower_interval.upper)},
            {"central_90_percent_upper_interval",
             interval(found.upper_interval.lower, found.upper_interval.upper)}};
}

calibrate::BulkStem bulk_stem(const json& stem) {
    calibrate::BulkStem bulk;
    const json& chain = stem.at("chain");
    bulk.id = stem.at("measurement").get<std::string>();
    bulk.law = chain.at("law").get<std::string>();
    bulk.stem.sphere_count = chain.at("spheres").get<int>();
    bulk.stem.bond_length = chain.at("bond_length_m").get<double>();
    bulk.stem.sphere_diameter = chain.at("sphere_diameter_m").get<double>();
    bulk.stem.density = chain.at("sphere_density_kg_m3").get<double>();
    bulk.stem.tip_mass_share = chain.at("tip_mass_share").get<double>();
    bulk.stem.bond_outer_diameter = chain.at("bond_outer_diameter_m").get<double>();
    bulk.stem.bond_inner_diameter = chain.at("bond_inner_diameter_m").get<double>();
    bulk.stem.poissons_ratio = chain.at("poissons_ratio").get<double>();
    const json& parameters = stem.at("parameters");
    bulk.stem.bond_youngs_modulus =
        parameters.at("bond_youngs_modulus_pa").at("value").get<double>();
    bulk.stem.bond_damping = parameters.at("bond_damping").at("value").get<double>();
    for (const json& mass : chain.at("added_masses"))
        bulk.added_masses.push_back(
            {mass.at("height_m").get<double>(), mass.at("mass_kg").get<double>()});
    for (const json& effect : chain.at("effects"))
        bulk.effects.push_back({effect.at("name").get<std::string>(),
                                effect.at("values").get<std::map<std::string, double>>()});
    bulk.reduced_chi_squared = stem.at("fit").at("reduced_chi2").get<double>();
    bulk.is_adequate = stem.at("fit").at("adequate").get<bool>();
    return bulk;
}

} // namespace

json calibration_json(const calibrate::Calibration& calibration, const std::string& law) {
    json out{{"measurement", calibration.id},
             {"parameters", stem_parameters_json(calibration)},
             {"correlation", correlation_json(calibration.fit)},
             {"mode", mode_json(calibration)},
             {"fit", fit_quality_json(calibration)},
             {"chain", chain_json(calibration.fit, law)},
             {"remarks", calibration.fit.model.remarks}};
    if (calibration.check || !calibration.check_failure.empty())
        out["check"] = check_json(calibration);
    return out;
}

json study_calibration_json(const calibrate::StudyCalibration& found, const std::string& study) {
    const auto law = [](const reduce::ParameterPrediction& prediction) {
        return json{{"single_law", prediction_json(prediction.by_single_law)},
                    {"f_test_terms", prediction_json(prediction.by_reduced_model)}};
    };
    return {{"study", study},
            {"height_mm", 1e3 * found.height},
            {"window_s", found.window},
            {"b1_per_cycle", value_json(found.reading.decay_per_cycle,
                                        found.reading.decay_per_cycle_standard_error)},
            {"b2_hz", value_json(found.reading.frequency, found.reading.frequency_standard_error)},
            {"bond_youngs_modulus_pa", law(found.prediction.bond_youngs_modulus)},
            {"bond_damping", law(found.prediction.bond_damping)},
            {"inside_design", found.prediction.is_inside_design},
            {"warnings", found.warnings}};
}

json population_json(const json& stems) {
    std::vector<double> moduli;
    std::vector<double> dampings;
    std::vector<double> decays;
    std::vector<double> frequencies;
    std::size_t inadequate = 0;
    for (const json& stem : stems) {
        if (stem.contains("failure"))
            continue;
        moduli.push_back(stem["parameters"]["bond_youngs_modulus_pa"]["value"].get<double>());
        dampings.push_back(stem["parameters"]["bond_damping"]["value"].get<double>());
        decays.push_back(stem["mode"]["b1_per_cycle"]["value"].get<double>());
        frequencies.push_back(stem["mode"]["b2_hz"]["value"].get<double>());
        inadequate += stem["fit"]["adequate"].get<bool>() ? 0 : 1;
    }
    if (moduli.size() < 2)
        return nullptr;
    return {{"stems", moduli.size()},
            {"failed", stems.size() - moduli.size()},
            {"something_missing", inadequate},
            {"bond_youngs_modulus_pa", central_range_json(moduli)},
            {"bond_damping", central_range_json(dampings)},
            {"b1_per_cycle", central_range_json(decays)},
            {"b2_hz", central_range_json(frequencies)}};
}

std::vector<calibrate::BulkStem> bulk_stems(const std::string& text, const std::string& file,
                                            const std::string& id) {
    std::vector<calibrate::BulkStem> stems;
    std::vector<std::string> names;
    try {
        const json document = json::parse(text);
        if (document.at("format") != "culm-calibration")
            throw core::InputError(
                fmt::format("{}: format = {}; `culm calibrate --json` writes \"culm-calibration\"",
                            file, document.at("format").dump()));
        for (const json& stem : document.at("stems")) {
            names.push_back(stem.at("measurement").get<std::string>());
            if (stem.contains("failure") || !(id.empty() || names.back() == id))
                continue;
            if (!stem.at("chain").contains("added_masses"))
                throw core::InputError(
                    fmt::format("{}: {}: written before calibrations stored added masses; "
                                "calibrate the stem again",
                                file, names.back()));
            stems.push_back(bulk_stem(stem));
        }
    } catch (const json::exception& error) {
        throw core::InputError(
            fmt::format("{}: not what `culm calibrate --json` writes: {}", file, error.what()));
    }
    if (stems.empty()) {
        const std::string nearest = core::nearest_name(id, names);
        throw core::InputError(fmt::format(
            "{}: no calibrated stem{}{}", file, id.empty() ? "" : fmt::format(" \"{}\"", id),
            nearest.empty() || nearest == id ? ""
                                             : fmt::format("; did you mean \"{}\"?", nearest)));
    }
    return stems;
}

} // namespace culm::cli
