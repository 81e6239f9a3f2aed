// SPDX-License-Identifier: BSD-3-Clause
#include "present/calibration.hpp"

#include "fit/solve/residual_statistics.hpp"
#include "present/files.hpp"
#include "present/parameters.hpp"
#include "present/text.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include <fmt/format.h>

namespace culm::present {
namespace {

using nlohmann::json;

/// A number with its standard error.
struct Uncertain {
    double value = 0.0;
    double standard_error = 0.0;
};

json json_of(const Uncertain& estimate) {
    return estimate_json(estimate.value, estimate.standard_error);
}

std::string plus_minus(const Uncertain& estimate, double scale = 1.0) {
    return present::plus_minus(estimate.value, estimate.standard_error, scale);
}

/// The parameter with its combined uncertainty from the budget.
Uncertain parameter_of(const calibrate::Calibration& calibration, const physics::ParameterId& id) {
    const fit::FittedParameter& parameter = *calibration.part().find(id);
    return {parameter.value, parameter.standard_error};
}

Uncertain frequency_of(const calibrate::Calibration& calibration) {
    return {calibration.mode.frequency, calibration.frequency_error};
}

Uncertain decay_of(const calibrate::Calibration& calibration) {
    return {calibration.mode.decay_per_cycle, calibration.decay_error};
}

json stem_parameters_json(const calibrate::Calibration& calibration) {
    json out = json::object();
    for (const auto& [key, parameter] : by_key(calibration.fit.parameters)) {
        const auto k = static_cast<std::size_t>(parameter - calibration.fit.parameters.data());
        out[key] = estimate_json(parameter->value, calibration.budget.combined[k]);
        out[key]["stderr_of_readings"] = number(calibration.budget.from_readings[k]);
    }
    return out;
}

json correlation_json(const fit::Fit& fit) {
    const std::size_t count = fit.parts.front().model.first_error();
    const auto correlation = [&fit](std::size_t a, std::size_t b) {
        const Eigen::MatrixXd& of = fit.covariance;
        const auto i = static_cast<Eigen::Index>(a);
        const auto j = static_cast<Eigen::Index>(b);
        const double scale = std::sqrt(of(i, i) * of(j, j));
        const bool is_reversed = (fit.parameters[a].fitted_as == physics::FittedAs::Inverse) !=
                                 (fit.parameters[b].fitted_as == physics::FittedAs::Inverse);
        return a == b ? 1.0 : scale > 0.0 ? (is_reversed ? -1.0 : 1.0) * of(i, j) / scale : 0.0;
    };
    const auto row = [&correlation, count](std::size_t a) {
        return array_of_count(
            count, [&correlation, a](std::size_t b) { return number(correlation(a, b)); });
    };
    return {{"names", array_of(std::span(fit.parameters).first(count), parameter_key)},
            {"matrix", array_of_count(count, row)}};
}

/// All data that `culm export` needs to write the chain without the recording.
json chain_json(const fit::RecordingFit& fit, const std::string& law) {
    const physics::StemParameters<double>& stem = fit.model.spec.stem;
    const auto effect_json = [](const physics::ActiveEffect& active) -> json {
        json values = json::object();
        const auto parameters = active.effect->parameters();
        for (std::size_t k = 0; k < parameters.size(); ++k)
            values[parameters[k].name] = number(active.values[k]);
        return {{"name", active.effect->name()}, {"values", values}};
    };
    const auto mass_json = [](const run::PointMass& mass) -> json {
        return {{"height_m", mass.height}, {"mass_kg", mass.mass}};
    };
    const run::CaseSpec computed = fit::computed_case(fit.model);
    return {{"law", law},
            {"bond_youngs_modulus_pa", number(computed.stem.bond_youngs_modulus)},
            {"bond_damping", number(computed.stem.bond_damping)},
            {"spheres", stem.sphere_count},
            {"bond_length_m", stem.bond_length},
            {"sphere_diameter_m", stem.sphere_diameter},
            {"sphere_density_kg_m3", stem.density},
            {"tip_mass_share", stem.tip_mass_share},
            {"bond_outer_diameter_m", stem.bond_outer_diameter},
            {"bond_inner_diameter_m", stem.bond_inner_diameter},
            {"poissons_ratio", stem.poissons_ratio},
            {"added_masses", array_of(fit.model.spec.added_masses, mass_json)},
            {"effects", array_of(fit.model.spec.effects, effect_json)}};
}

/// The first three failed tests and the number of the others; without any the verdict's reason.
std::string short_reason(const diagnose::Verdict& verdict) {
    constexpr std::size_t most = 3;
    const std::vector<std::string>& names = verdict.failed_tests;
    if (names.size() <= most)
        return verdict.reason;
    return fmt::format("{}, {}, {} and {} more", names[0], names[1], names[2], names.size() - most);
}

std::string adequacy_text(const diagnose::Verdict& verdict) {
    if (verdict.finding == diagnose::Finding::Adequate)
        return "No model deficiency detectable in this recording.";
    if (verdict.finding == diagnose::Finding::Inadequate)
        return fmt::format("Model inadequate; failed tests: {}.", short_reason(verdict));
    return fmt::format("Undecided whether the model is adequate: {}.", verdict.reason);
}

/// Y, β and the verdict.
std::string calibration_sentence(const calibrate::Calibration& calibration) {
    return fmt::format("{}: Y = {} GPa, beta = {} (95 %). {}", calibration.id,
                       plus_minus(parameter_of(calibration, physics::bond_youngs_modulus), 1e-9),
                       plus_minus(parameter_of(calibration, physics::bond_damping)),
                       adequacy_text(calibration.verdict));
}

std::string stem_line_of(const calibrate::Calibration& calibration) {
    return measure::stem_line(calibration.stem,
                              parameter_of(calibration, physics::bond_youngs_modulus).value);
}

json fit_quality_json(const calibrate::Calibration& calibration) {
    const fit::RecordingFit& fit = calibration.part();
    return {{"rmse_mm", 1e3 * fit.rmse},
            {"noise_mm", 1e3 * fit::typical_noise(fit)},
            {"noise_source", fit.noise_source},
            {"rmse_over_noise", number(fit::over_noise(fit))},
            {"reduced_chi2", number(calibration.fit.reduced_chi_squared)},
            {"contradicted_inputs", contradictions_json(calibration.fit.pulls)},
            {"degrees_of_freedom", fit.degrees_of_freedom},
            {"readings", fit.readings},
            {"runs", calibration.fit.batches},
            {"adequate", calibration.verdict.finding == diagnose::Finding::Adequate},
            {"reason", calibration.verdict.reason},
            {"failed_tests", calibration.verdict.failed_tests},
            {"tests", tests_json(calibration.verdict.tests)}};
}

json mode_json(const calibrate::Calibration& calibration) {
    return {{"b2_hz", json_of(frequency_of(calibration))},
            {"b1_per_cycle", json_of(decay_of(calibration))},
            {"natural_frequency_hz", calibration.mode.natural_frequency()},
            {"damping_ratio", calibration.mode.damping_ratio()},
            {"damping_time_s", calibration.damping_time}};
}

/// The errors, and the resolution of the reading; an error below the resolution is not significant.
json check_json(const calibrate::Calibration& calibration) {
    if (!calibration.check)
        return {{"failure", calibration.check_failure}};
    const calibrate::CalibrationCheck& check = *calibration.check;
    return {{"measured_b1_per_cycle", check.decay_per_cycle.measured},
            {"simulated_b1_per_cycle", check.decay_per_cycle.simulated},
            {"b1_error_percent", 100.0 * check.decay_per_cycle.relative_error()},
            {"b1_resolution_percent", 100.0 * check.decay_per_cycle.resolution()},
            {"measured_b2_hz", check.frequency.measured},
            {"simulated_b2_hz", check.frequency.simulated},
            {"b2_error_percent", 100.0 * check.frequency.relative_error()},
            {"b2_resolution_percent", 100.0 * check.frequency.resolution()}};
}

json prediction_json(const std::optional<reduce::Prediction>& found) {
    return found ? interval_json(*found) : json(nullptr);
}

/// 5 % and 95 % quantiles, and the bootstrap interval of either end.
json central_range_json(const calibrate::CentralRange& found) {
    return {{"mean", found.sample.mean},
            {"standard_deviation", number(found.sample.standard_deviation)},
            {"median", found.sample.median},
            {"lowest", found.sample.lowest},
            {"highest", found.sample.highest},
            {"central_90_percent", bounds_json(found.range)},
            {"central_90_percent_lower_interval", bounds_json(found.lower_interval)},
            {"central_90_percent_upper_interval", bounds_json(found.upper_interval)}};
}

/// The parameters with the combined uncertainty of the budget, in the order of the JSON's keys, so
/// that both can be compared line by line.
std::string parameter_lines(const calibrate::Calibration& calibration) {
    std::string text;
    for (const auto& [key, parameter] : by_key(calibration.fit.parameters)) {
        const auto place = parameter - calibration.fit.parameters.data();
        fit::FittedParameter with_budget = *parameter;
        with_budget.standard_error = calibration.budget.combined[static_cast<std::size_t>(place)];
        text += fmt::format("    {:<24} {}\n", readable(*parameter).name, value_text(with_budget));
    }
    return text;
}

/// The sentence in yellow, in lines after an indent.
std::string warning_lines(const std::string& indent, const std::string& sentence,
                          const TextStyle& style) {
    const std::string lines = result_lines(indent, sentence);
    return indent + style.warning(lines.substr(indent.size(), lines.size() - indent.size() - 1)) +
           '\n';
}

std::string verdict_lines(const calibrate::Calibration& calibration, const TextStyle& style) {
    const std::string verdict = adequacy_text(calibration.verdict);
    const std::string said = contradiction_sentence(
        calibration.fit.pulls, calibration.verdict.finding != diagnose::Finding::Inadequate);
    return (calibration.verdict.finding == diagnose::Finding::Adequate
                ? "  " + style.good(verdict) + '\n'
                : warning_lines("  ", verdict, style)) +
           (said.empty() ? said : warning_lines("  ", said, style));
}

std::string check_lines(const calibrate::Calibration& calibration) {
    if (!calibration.check)
        return calibration.check_failure.empty()
                   ? std::string()
                   : fmt::format("  check: not possible: {}\n", calibration.check_failure);
    const calibrate::CalibrationCheck& check = *calibration.check;
    return fmt::format(
        "  check: Eq. 1 fitted to the simulated stem and to the measured one\n"
        "    b1 per cycle  simulated {:.4f}, measured {:.4f}, error {:+.2f} % (resolution {:.2f} "
        "%)\n"
        "    b2            simulated {:.3f} Hz, measured {:.3f} Hz, error {:+.3f} % (resolution "
        "{:.3f} %)\n",
        check.decay_per_cycle.simulated, check.decay_per_cycle.measured,
        100.0 * check.decay_per_cycle.relative_error(), 100.0 * check.decay_per_cycle.resolution(),
        check.frequency.simulated, check.frequency.measured,
        100.0 * check.frequency.relative_error(), 100.0 * check.frequency.resolution());
}

/// "Y = 1.9 (95 %: 1.8 … 2.0) GPa, beta = …" by one of the two kinds of laws.
std::string law_text(const reduce::StemPrediction& stem,
                     std::optional<reduce::Prediction> reduce::ParameterPrediction::*kind) {
    const auto one = [kind](const reduce::ParameterPrediction& parameter, double scale,
                            int decimals) {
        const std::optional<reduce::Prediction>& found = parameter.*kind;
        return found ? fmt::format("{:.{}f} (95 %: {:.{}f} … {:.{}f})", scale * found->value,
                                   decimals, scale * found->lower, decimals, scale * found->upper,
                                   decimals)
                     : std::string("none");
    };
    return fmt::format("Y = {} GPa, beta = {}", one(stem.bond_youngs_modulus, 1e-9, 4),
                       one(stem.bond_damping, 1.0, 2));
}

std::string range_line(const char* name, const calibrate::CentralRange& found, double scale,
                       const char* unit) {
    return fmt::format("    {:<14} {:.4g} … {:.4g} {} (ends, 95 % by bootstrap: {:.4g} … {:.4g} "
                       "and {:.4g} … {:.4g}); mean {:.4g}, sd {:.3g}\n",
                       name, scale * found.range.lower, scale * found.range.upper, unit,
                       scale * found.lower_interval.lower, scale * found.lower_interval.upper,
                       scale * found.upper_interval.lower, scale * found.upper_interval.upper,
                       scale * found.sample.mean, scale * found.sample.standard_deviation);
}

Uncertain read_decay(const calibrate::StudyCalibration& found) {
    return {found.reading.decay_per_cycle, found.reading.decay_per_cycle_standard_error};
}

Uncertain read_frequency(const calibrate::StudyCalibration& found) {
    return {found.reading.frequency, found.reading.frequency_standard_error};
}

} // namespace

json calibration_json(const calibrate::Calibration& calibration, const std::string& law) {
    json out{{"measurement", calibration.id},
             {"sentence", calibration_sentence(calibration)},
             {"stem", stem_line_of(calibration)},
             {"parameters", stem_parameters_json(calibration)},
             {"uncertainty_budget", budget_json(calibration.budget, calibration.fit.parameters)},
             {"correlation", correlation_json(calibration.fit)},
             {"mode", mode_json(calibration)},
             {"fit", fit_quality_json(calibration)},
             {"chain", chain_json(calibration.part(), law)},
             {"remarks", calibration.part().model.remarks}};
    if (calibration.check || !calibration.check_failure.empty())
        out["check"] = check_json(calibration);
    return out;
}

std::string calibration_text(const calibrate::Calibration& calibration, const std::string& law,
                             bool with_details, const TextStyle& style) {
    const fit::RecordingFit& fit = calibration.part();
    const std::string far_off = far_off_sentence(fit::over_noise(fit));
    std::string text =
        fmt::format("{}: chain of {} spheres, law {}, fitted to {} readings (intervals 95 %)\n{}{}",
                    calibration.id, fit.model.spec.stem.sphere_count, law, fit.readings,
                    far_off.empty() ? far_off : warning_lines("  ", far_off, style),
                    parameter_lines(calibration));
    text += result_lines("  ", "stem: " + stem_line_of(calibration));
    text += fmt::format("  first mode: b2 {} Hz, b1 per cycle {}, damping ratio {:.5f}\n",
                        plus_minus(frequency_of(calibration)), plus_minus(decay_of(calibration)),
                        calibration.mode.damping_ratio());
    const measure::ReadingUnit unit = measure::reading_unit(fit.model.spec.sensors);
    text += result_lines("  ", fmt::format("residual {} rms, {:.2f} times the noise of {} ({})",
                                           unit.text(fit.rmse), fit::over_noise(fit),
                                           unit.text(fit::typical_noise(fit)), fit.noise_source));
    text += fmt::format("  reduced chi2 {:.3f} with the inputs free within their uncertainties\n",
                        calibration.fit.reduced_chi_squared);
    text += verdict_lines(calibration, style) + check_lines(calibration);
    return text + (with_details
                       ? budget_text(calibration.budget, calibration.fit.parameters)
                       : largest_shares_text(calibration.budget, calibration.fit.parameters));
}

std::string calibration_table_head(bool is_checked) {
    return fmt::format("{:<14} {:>18} {:>16} {:>18} {:>17} {:>8}  {}{}\n", "stem", "Y GPa", "beta",
                       "b1 per cycle", "b2 Hz", "chi2/dof",
                       is_checked ? fmt::format("{:>9} {:>9}  ", "b1 error", "b2 error") : "",
                       "failed tests");
}

std::string calibration_table_line(const calibrate::Calibration& calibration, bool is_checked,
                                   const TextStyle& style) {
    std::string check;
    if (is_checked)
        check = calibration.check
                    ? fmt::format("{:>+8.2f}% {:>+8.3f}%  ",
                                  100.0 * calibration.check->decay_per_cycle.relative_error(),
                                  100.0 * calibration.check->frequency.relative_error())
                    : fmt::format("{:>9} {:>9}  ", "-", "-");
    return fmt::format("{:<14} {:>18} {:>16} {:>18} {:>17} {:>8.4f}  {}{}\n", calibration.id,
                       plus_minus(parameter_of(calibration, physics::bond_youngs_modulus), 1e-9),
                       plus_minus(parameter_of(calibration, physics::bond_damping)),
                       plus_minus(decay_of(calibration)), plus_minus(frequency_of(calibration)),
                       calibration.fit.reduced_chi_squared, check,
                       calibration.verdict.finding == diagnose::Finding::Adequate
                           ? std::string("-")
                           : style.warning(short_reason(calibration.verdict)));
}

json study_calibration_json(const calibrate::StudyCalibration& found, const std::string& study) {
    const auto law = [](const reduce::ParameterPrediction& prediction) {
        return json{{"single_law", prediction_json(prediction.by_single_law)},
                    {"f_test_terms", prediction_json(prediction.by_reduced_model)}};
    };
    return {{"study", study},
            {"height_mm", 1e3 * found.height},
            {"window_s", found.window},
            {"b1_per_cycle", json_of(read_decay(found))},
            {"b2_hz", json_of(read_frequency(found))},
            {"bond_youngs_modulus_pa", law(found.prediction.bond_youngs_modulus)},
            {"bond_damping", law(found.prediction.bond_damping)},
            {"inside_design", found.prediction.is_inside_design},
            {"warnings", found.warnings}};
}

std::string study_calibration_text(const calibrate::StudyCalibration& found,
                                   const std::string& study, const std::string& law,
                                   const TextStyle& style) {
    std::string text =
        fmt::format("  by the study {}, law {}, window {:.4g} s\n    h = {:.4g} mm      b1 per "
                    "cycle {}, b2 {} Hz\n    Eqs. 12-13    {}\n    F-test terms  {}\n",
                    study, law, found.window, 1e3 * found.height, plus_minus(read_decay(found)),
                    plus_minus(read_frequency(found)),
                    law_text(found.prediction, &reduce::ParameterPrediction::by_single_law),
                    law_text(found.prediction, &reduce::ParameterPrediction::by_reduced_model));
    for (const std::string& warning : found.warnings)
        text += warning_lines("    ", "WARNING: " + warning, style);
    return text;
}

StemNumbers numbers_of(const calibrate::Calibration& calibration) {
    return {parameter_of(calibration, physics::bond_youngs_modulus).value,
            parameter_of(calibration, physics::bond_damping).value,
            calibration.mode.decay_per_cycle, calibration.mode.frequency,
            calibration.verdict.finding == diagnose::Finding::Adequate};
}

// A spread needs at least two stems.
std::optional<Population> population_of(std::span<const StemNumbers> calibrated,
                                        std::size_t failed) {
    if (calibrated.size() < 2)
        return std::nullopt;
    const auto range = [calibrated](double StemNumbers::*quantity) {
        std::vector<double> values;
        values.reserve(calibrated.size());
        for (const StemNumbers& stem : calibrated)
            values.push_back(stem.*quantity);
        return calibrate::central_range(values);
    };
    const auto inadequate =
        std::ranges::count_if(calibrated, std::not_fn(&StemNumbers::is_adequate));
    return Population{calibrated.size(),
                      failed,
                      static_cast<std::size_t>(inadequate),
                      range(&StemNumbers::bond_youngs_modulus),
                      range(&StemNumbers::bond_damping),
                      range(&StemNumbers::decay_per_cycle),
                      range(&StemNumbers::frequency)};
}

json population_json(const Population& population) {
    return {{"stems", population.stems},
            {"failed", population.failed},
            {"something_missing", population.inadequate},
            {"bond_youngs_modulus_pa", central_range_json(population.bond_youngs_modulus)},
            {"bond_damping", central_range_json(population.bond_damping)},
            {"b1_per_cycle", central_range_json(population.decay_per_cycle)},
            {"b2_hz", central_range_json(population.frequency)}};
}

std::string population_text(const Population& population) {
    return fmt::format("{} stems calibrated, {} failed; model inadequate for {}\n90 % of the stems "
                       "lie in\n",
                       population.stems, population.failed, population.inadequate) +
           range_line("Y", population.bond_youngs_modulus, 1e-9, "GPa") +
           range_line("beta", population.bond_damping, 1.0, "") +
           range_line("b1 per cycle", population.decay_per_cycle, 1.0, "") +
           range_line("b2", population.frequency, 1.0, "Hz");
}

} // namespace culm::present
