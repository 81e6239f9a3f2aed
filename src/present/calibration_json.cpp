// SPDX-License-Identifier: BSD-3-Clause
#include "core/describe.hpp"
#include "fit/solve/residual_statistics.hpp"
#include "present/calibration.hpp"
#include "present/laboratory.hpp"
#include "present/parameters.hpp"

#include <cmath>
#include <map>
#include <string>
#include <vector>

namespace culm::present {
namespace {

using nlohmann::json;

using ByParameter = std::map<std::string, double>;

template <class To>
void describe_budget(To& to, const fit::UncertaintyBudget& budget,
                     std::span<const fit::FittedParameter> parameters) {
    const auto by_parameter = [parameters](const auto& value) {
        ByParameter out;
        for (std::size_t p = 0; p < parameters.size(); ++p)
            out[parameter_key(parameters[p])] = value(p);
        return out;
    };
    to.list("inputs", budget.inputs, [&](const fit::BudgetInput& line) {
        to("name", line.input.name);
        to("unit", line.input.unit);
        to("value", line.input.value);
        to("standard_uncertainty", line.input.standard_uncertainty);
        to("default", line.input.is_default, "true: none is stated");
        to("pull", line.pull, "(fitted - stated value)/uncertainty");
        to("uncertainty_with_readings", line.uncertainty_with_readings);
        to("sensitivities",
           [&] { return by_parameter([&](std::size_t p) { return line.sensitivities[p]; }); });
        to("shares", [&] {
            const auto k = static_cast<std::size_t>(&line - budget.inputs.data());
            return by_parameter([&](std::size_t p) { return budget.share(k, p); });
        });
    });
    to.object("readings", [&] {
        to("standard_uncertainties",
           [&] { return by_parameter([&](std::size_t p) { return budget.from_readings[p]; }); });
        to("shares", [&] {
            return by_parameter([&](std::size_t p) { return budget.share_of_readings(p); });
        });
    });
    to("combined", [&] { return by_parameter([&](std::size_t p) { return budget.combined[p]; }); });
    to("sentences", [&] {
        const std::string defaults = defaults_sentence(budget);
        return defaults.empty() ? std::vector<std::string>() : std::vector{defaults};
    });
}

/// The correlations of the parameters of the chain, without error terms.
std::vector<std::vector<double>> correlation_of(const fit::Fit& fit, std::size_t count) {
    const auto correlation = [&fit](std::size_t a, std::size_t b) {
        const Eigen::MatrixXd& of = fit.covariance;
        const auto i = static_cast<Eigen::Index>(a);
        const auto j = static_cast<Eigen::Index>(b);
        const double scale = std::sqrt(of(i, i) * of(j, j));
        const bool is_reversed = (fit.parameters[a].fitted_as == physics::FittedAs::Inverse) !=
                                 (fit.parameters[b].fitted_as == physics::FittedAs::Inverse);
        return a == b ? 1.0 : scale > 0.0 ? (is_reversed ? -1.0 : 1.0) * of(i, j) / scale : 0.0;
    };
    std::vector<std::vector<double>> matrix(count);
    for (std::size_t a = 0; a < count; ++a)
        for (std::size_t b = 0; b < count; ++b)
            matrix[a].push_back(correlation(a, b));
    return matrix;
}

/// All data that `culm export` needs to write the chain without the recording.
template <class To>
void describe_chain(To& to, const fit::StemModel& model, const std::string& law) {
    const physics::StemParameters<double>& stem = model.spec.stem;
    to("law", law);
    to("bond_youngs_modulus_pa",
       [&] { return fit::computed_case(model).stem.bond_youngs_modulus; });
    to("bond_damping", [&] { return fit::computed_case(model).stem.bond_damping; });
    to("spheres", stem.sphere_count);
    to("bond_length_m", stem.bond_length);
    to("sphere_diameter_m", stem.sphere_diameter);
    to("sphere_density_kg_m3", stem.density);
    to("tip_mass_share", stem.tip_mass_share);
    to("bond_outer_diameter_m", stem.bond_outer_diameter);
    to("bond_inner_diameter_m", stem.bond_inner_diameter);
    to("poissons_ratio", stem.poissons_ratio);
    to.list("added_masses", model.spec.added_masses, [&](const physics::AttachedMass& mass) {
        to("height_m", mass.position);
        to("mass_kg", mass.mass);
    });
    to.list("effects", model.spec.effects, [&](const physics::ActiveEffect& active) {
        to("name", [&] { return active.effect->name; });
        to("values", [&] {
            ByParameter values;
            const auto& parameters = active.effect->parameters;
            for (std::size_t k = 0; k < parameters.size(); ++k)
                values[parameters[k].name] = active.values[k];
            return values;
        });
    });
}

template <class To>
void describe_quality(To& to, const calibrate::Calibration& calibration,
                      const fit::RecordingFit& part) {
    const diagnose::Verdict& verdict = calibration.verdict;
    to("rmse_mm", part.rmse);
    to("noise_mm", [&] { return fit::typical_noise(part); });
    to("noise_source", part.noise_source);
    to("rmse_over_noise", [&] { return fit::over_noise(part); });
    to("reduced_chi2", calibration.fit.reduced_chi_squared);
    to("contradicted_inputs", [&] { return contradictions_of(calibration.fit.pulls); });
    to("degrees_of_freedom", part.degrees_of_freedom);
    to("readings", part.readings);
    to("runs", calibration.fit.batches);
    to("adequate", [&] { return verdict.finding == diagnose::Finding::Adequate; });
    to("reason", verdict.reason);
    to("failed_tests", verdict.failed_tests);
    to("tests", verdict.tests);
}

/// Y and β by a study's regressions, or why there are none.
template <class To>
void describe_study(To& to, const CalibratedStem& stem) {
    const auto laws = [&](const char* key, const reduce::ParameterPrediction& prediction) {
        to.object(key, [&] {
            to("single_law", prediction.by_single_law);
            to("f_test_terms", prediction.by_reduced_model);
        });
    };
    to.when(!stem.by_study, [&] { to("failure", stem.study_failure); });
    to.when(stem.by_study, [&](const calibrate::StudyCalibration& found) {
        to("study", stem.study);
        to("height_mm", found.height);
        to("window_s", found.window);
        to("b1_per_cycle", found.reading.decay_per_cycle);
        to("b2_hz", found.reading.frequency);
        laws("bond_youngs_modulus_pa", found.prediction.bond_youngs_modulus);
        laws("bond_damping", found.prediction.bond_damping);
        to("inside_design", found.prediction.is_inside_design);
        to("warnings", found.warnings);
    });
}

template <class To>
void describe_calibration(To& to, const calibrate::Calibration& of, const std::string& law) {
    static const fit::RecordingFit no_part;
    const fit::RecordingFit& part = of.fit.parts.empty() ? no_part : of.part();
    to(
        "sentence", [&] { return calibration_sentence(of); }, "Y, beta and the verdict");
    to("stem", [&] { return stem_line_of(of); });
    to("parameters", [&] { return shown_parameters(of.fit.parameters); });
    to.object("uncertainty_budget", [&] { describe_budget(to, of.budget, of.fit.parameters); });
    to.object("correlation", [&] {
        const auto count = [&] { return part.model.first_error(); };
        to("names", [&] {
            std::vector<std::string> names;
            for (std::size_t k = 0; k < count(); ++k)
                names.push_back(parameter_key(of.fit.parameters[k]));
            return names;
        });
        to("matrix", [&] { return correlation_of(of.fit, count()); });
    });
    to.object("mode", [&] {
        to("b2_hz", of.frequency);
        to("b1_per_cycle", of.decay_per_cycle);
        to("natural_frequency_hz", [&] { return of.mode.natural_frequency(); });
        to("damping_ratio", [&] { return of.mode.damping_ratio(); });
        to("damping_time_s", of.damping_time);
    });
    to("still_air_bias", of.still_air_bias,
       "relative error of Y because still air moves with the stem; 0: the model has that air");
    to.object("fit", [&] { describe_quality(to, of, part); });
    to.object("chain", [&] { describe_chain(to, part.model, law); });
    to("remarks", [&] { return remarks_on(part); });
}

} // namespace

template <class To>
void describe(To& to, const CalibratedStem& stem) {
    static const calibrate::Calibration no_calibration{};
    const calibrate::Calibration& calibration =
        stem.calibration ? *stem.calibration : no_calibration;
    to("measurement", stem.id);
    to("folder", stem.folder);
    to.when(!stem.failure.empty(), [&] { to("failure", stem.failure); });
    to.when(stem.failure.empty(), [&] { describe_calibration(to, calibration, stem.law); });
    to.when(stem.by_study || !stem.study_failure.empty(),
            [&] { to.object("via", [&] { describe_study(to, stem); }); });
}

template <class To>
void describe(To& to, const CalibrationDocument& document) {
    to.constant("format", "culm-calibration");
    to.constant("version", 1);
    to.object("options", [&] {
        to("law", document.law);
        to("with", document.effects);
        to("window_s", document.window);
    });
    describe_rig_effects(to, "shared_effects", document.shared_effects);
    to("population", document.population);
    to.template encoded<CalibratedStem>("stems", document.stems);
    to("remarks", document.remarks);
    to("provenance", document.provenance);
}

std::string stem_document(const CalibratedStem& stem) {
    return core::json_of(stem).dump();
}

json calibration_json(const CalibrationDocument& document) {
    return core::json_of(document);
}

json calibration_schema() {
    return core::schema_of<CalibrationDocument>();
}

} // namespace culm::present
