// SPDX-License-Identifier: BSD-3-Clause
#include "present/calibration.hpp"

#include "fit/solve/residual_statistics.hpp"
#include "present/parameters.hpp"
#include "present/text.hpp"

#include <vector>

#include <fmt/format.h>

namespace culm::present {
namespace {

/// A parameter with the combined uncertainty of the budget.
reduce::Estimate estimate_of(const calibrate::Calibration& calibration,
                             const physics::ParameterId& id) {
    const fit::FittedParameter& parameter = *calibration.part().find(id);
    return reduce::normal_estimate(parameter.value, parameter.standard_error);
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

/// The parameters with the combined uncertainty of the budget, in the order of the JSON's keys, so
/// that both can be compared line by line.
std::string parameter_lines(const calibrate::Calibration& calibration) {
    std::string text;
    for (const auto& [key, parameter] : by_key(calibration.fit.parameters))
        text += fmt::format("    {:<24} {}\n", readable(*parameter).name, value_text(*parameter));
    return text;
}

std::string verdict_lines(const calibrate::Calibration& calibration) {
    const std::string said = contradiction_sentence(
        calibration.fit.pulls, calibration.verdict.finding != diagnose::Finding::Inadequate);
    return result_lines("  ", adequacy_text(calibration.verdict)) +
           (said.empty() ? said : result_lines("  ", said));
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

std::string range_line(const char* name, const reduce::SampleSummary& found, double scale,
                       const char* unit) {
    return fmt::format(
        "    {:<14} {:.4g} … {:.4g} {}; mean {:.4g} (95 %: {:.4g} … {:.4g}), sd "
        "{:.3g} ({:.3g} … {:.3g})\n",
        name, scale * found.central_90_percent.lower, scale * found.central_90_percent.upper, unit,
        scale * found.mean, scale * found.mean_interval.lower, scale * found.mean_interval.upper,
        scale * found.standard_deviation, scale * found.standard_deviation_interval.lower,
        scale * found.standard_deviation_interval.upper);
}

} // namespace

std::string calibration_sentence(const calibrate::Calibration& calibration) {
    return fmt::format("{}: Y = {} GPa, beta = {} (95 %). {}", calibration.id,
                       plus_minus(estimate_of(calibration, physics::bond_youngs_modulus), 1e-9),
                       plus_minus(estimate_of(calibration, physics::bond_damping)),
                       adequacy_text(calibration.verdict));
}

std::string stem_line_of(const calibrate::Calibration& calibration) {
    return measure::stem_line(calibration.stem,
                              calibration.part().find(physics::bond_youngs_modulus)->value);
}

std::string calibration_text(const calibrate::Calibration& calibration, const std::string& law,
                             bool with_details) {
    const fit::RecordingFit& fit = calibration.part();
    const std::string far_off = far_off_sentence(fit::over_noise(fit));
    std::string text = fmt::format(
        "{}: chain of {} spheres, law {}, fitted to {} readings (intervals 95 %)\n{}{}",
        calibration.id, fit.model.spec.stem.sphere_count, law, fit.readings,
        far_off.empty() ? far_off : result_lines("  ", far_off), parameter_lines(calibration));
    text += result_lines("  ", "stem: " + stem_line_of(calibration));
    text += fmt::format("  first mode: b2 {} Hz, b1 per cycle {}, damping ratio {:.5f}\n",
                        plus_minus(calibration.frequency), plus_minus(calibration.decay_per_cycle),
                        calibration.mode.damping_ratio());
    if (calibration.still_air_bias != 0.0)
        text += fmt::format("  still air moves with the stem, which biases Y by {} (--with "
                            "still_air removes it)\n",
                            percent_text(calibration.still_air_bias));
    const measure::ReadingUnit unit = measure::reading_unit(fit.model.spec.sensors);
    text += result_lines("  ", fmt::format("residual {} rms, {:.2f} times the noise of {} ({})",
                                           unit.text(fit.rmse), fit::over_noise(fit),
                                           unit.text(fit::typical_noise(fit)), fit.noise_source));
    for (const std::string& remark : remarks_on(fit))
        text += result_lines("  ", remark);
    text += fmt::format("  reduced chi2 {:.3f} with the inputs free within their uncertainties\n",
                        calibration.fit.reduced_chi_squared);
    text += verdict_lines(calibration);
    return text + (with_details
                       ? budget_text(calibration.budget, calibration.fit.parameters)
                       : largest_shares_text(calibration.budget, calibration.fit.parameters));
}

std::string calibration_table_head() {
    return fmt::format("{:<14} {:>18} {:>9} {:>16} {:>18} {:>17} {:>8}  failed tests\n", "stem",
                       "Y GPa", "still air", "beta", "b1 per cycle", "b2 Hz", "chi2/dof");
}

std::string calibration_table_line(const calibrate::Calibration& calibration) {
    return fmt::format("{:<14} {:>18} {:>9} {:>16} {:>18} {:>17} {:>8.4f}  {}\n", calibration.id,
                       plus_minus(estimate_of(calibration, physics::bond_youngs_modulus), 1e-9),
                       calibration.still_air_bias == 0.0
                           ? "-"
                           : fmt::format("{:+.2f} %", 100.0 * calibration.still_air_bias),
                       plus_minus(estimate_of(calibration, physics::bond_damping)),
                       plus_minus(calibration.decay_per_cycle), plus_minus(calibration.frequency),
                       calibration.fit.reduced_chi_squared,
                       calibration.verdict.finding == diagnose::Finding::Adequate
                           ? std::string("-")
                           : short_reason(calibration.verdict));
}

std::string study_calibration_text(const calibrate::StudyCalibration& found,
                                   const std::string& study, const std::string& law) {
    std::string text =
        fmt::format("  by the study {}, law {}, window {:.4g} s\n    h = {:.4g} mm      b1 per "
                    "cycle {}, b2 {} Hz\n    Eqs. 12-13    {}\n    F-test terms  {}\n",
                    study, law, found.window, 1e3 * found.height,
                    plus_minus(found.reading.decay_per_cycle), plus_minus(found.reading.frequency),
                    law_text(found.prediction, &reduce::ParameterPrediction::by_single_law),
                    law_text(found.prediction, &reduce::ParameterPrediction::by_reduced_model));
    for (const std::string& warning : found.warnings)
        text += result_lines("    ", "WARNING: " + warning);
    return text;
}

std::string population_text(const calibrate::Population& population) {
    return fmt::format("{} stems calibrated, {} failed; model inadequate for {}\n90 % of the stems "
                       "lie in\n",
                       population.stems, population.failed, population.inadequate) +
           range_line("Y", population.bond_youngs_modulus, 1e-9, "GPa") +
           range_line("beta", population.bond_damping, 1.0, "") +
           range_line("b1 per cycle", population.decay_per_cycle, 1.0, "") +
           range_line("b2", population.frequency, 1.0, "Hz");
}

} // namespace culm::present
