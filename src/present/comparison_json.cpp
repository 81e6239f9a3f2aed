// SPDX-License-Identifier: BSD-3-Clause
#include "present/comparison.hpp"
#include "present/files.hpp"
#include "present/parameters.hpp"

#include <cmath>
#include <span>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace culm::present {
namespace {

using nlohmann::json;

constexpr double millimetres = 1e3;

/// Rounds to a nanometre: residuals and shapes are less accurate, and the file stays readable.
json millimetres_of(double metres) {
    return std::isfinite(metres) ? json(std::round(metres * 1e9) * 1e-6) : json(nullptr);
}

json millimetres_of(const std::vector<double>& metres) {
    return array_of(metres, [](double value) { return millimetres_of(value); });
}

json bare_estimate(const reduce::Estimate& found, double scale = 1.0) {
    return {{"value", number(scale * found.value)},
            {"stderr", number(scale * found.standard_error)}};
}

/// Includes the residual over noise, which is comparable between heights and times. `lower` and
/// `upper` are keys; heights have no upper end.
json groups_json(const std::vector<fit::ResidualGroup>& found, const char* lower, const char* upper,
                 double scale) {
    return array_of(found, [=](const fit::ResidualGroup& each) {
        json out{{"readings", each.readings},
                 {"rms_mm", number(millimetres * each.rms)},
                 {"mean_mm", number(millimetres * each.mean)},
                 {"rms_over_noise", number(each.over_noise)},
                 {lower, number(scale * each.lower)}};
        if (*upper != '\0')
            out[upper] = number(scale * each.upper);
        return out;
    });
}

json band_json(const fit::SpectrumBand& band) {
    return {{"name", band.name},
            {"lower_hz", band.lower},
            {"upper_hz", band.upper},
            {"share", number(band.share)}};
}

json spectrum_json(const fit::ResidualSpectrum& found) {
    return {{"frequency_hz", found.frequencies},
            {"power_over_noise", found.power},
            {"mode_frequencies_hz", found.mode_frequencies},
            {"bands", array_of(found.bands, band_json)}};
}

json window_fit_json(const std::optional<residuals::WindowFit>& found) {
    if (!found)
        return nullptr;
    return {{"amplitude_mm", number(millimetres * found->amplitude)},
            {"frequency_hz", bare_estimate(found->frequency)},
            {"b1_per_cycle", bare_estimate(found->decay_per_cycle)},
            {"rest_mm", bare_estimate(found->rest, millimetres)}};
}

/// Measured and modelled motion are fitted by Eq. 1 in the same windows, so that deviations from
/// Eq. 1 affect both alike.
json window_json(const residuals::SwingWindow& window) {
    return {{"begin_s", window.begin},
            {"end_s", window.end},
            {"measured", window_fit_json(window.measured)},
            {"modelled", window_fit_json(window.modelled)}};
}

json slope_json(const reduce::StemRingDowns& stem) {
    if (!stem.banding)
        return nullptr;
    return {{"slope", number(stem.banding->slope)}, {"p_value", number(stem.banding->p_value)}};
}

/// b1 per cycle at every height, and its slope along the stem (the paper's "banding").
json banding_json(const diagnose::Comparison& comparison) {
    const auto& measured = comparison.measured_ring_downs.heights;
    const auto& modelled = comparison.modelled_ring_downs.heights;
    const auto b1 = [](const reduce::HeightRingDown& height) {
        return height.fit ? bare_estimate(height.fit->decay_per_cycle) : json(nullptr);
    };
    const auto height = [&](std::size_t j) -> json {
        return {{"height_mm", millimetres * measured[j].height},
                {"measured", b1(measured[j])},
                {"modelled", b1(modelled[j])}};
    };
    return {{"heights", array_of_count(measured.size(), height)},
            {"measured", slope_json(comparison.measured_ring_downs)},
            {"modelled", slope_json(comparison.modelled_ring_downs)}};
}

json swing_error_json(const residuals::SwingError& error) {
    return {{"amplitude", number(error.amplitude)},
            {"amplitude_stderr", number(error.amplitude_error)},
            {"lag_rad", number(error.lag)},
            {"lag_stderr_rad", number(error.lag_error)},
            {"rest_mm", number(millimetres * error.rest)},
            {"rest_stderr_mm", number(millimetres * error.rest_error)},
            {"measured_over_noise", number(error.measured_over_noise)},
            {"modelled_over_noise", number(error.modelled_over_noise)}};
}

/// Errors in the thirds of the time: their growth, decay or change of sign indicates the effect.
json structure_json(const residuals::ResidualStructure& found) {
    return {{"thirds", array_of(found.thirds, swing_error_json)},
            {"shares",
             {{"amplitude", found.amplitude_share},
              {"phase", found.phase_share},
              {"rest", found.rest_share},
              {"other_motion", found.other_motion_share},
              {"other_shape", found.other_shape_share}}}};
}

json residual_map(const fit::RecordingFit& fit) {
    const std::size_t columns = fit.prediction.rows;
    const auto row = [&](std::size_t i) {
        return array_of(std::span(fit.residuals).subspan(i * columns, columns),
                        [](double residual) { return millimetres_of(residual); });
    };
    return {{"time_s", fit.times},
            {"height_mm",
             array_of(fit.model.spec.heights, [](double height) { return millimetres * height; })},
            {"residual_mm", array_of_count(fit.times.size(), row)}};
}

json verdict_json(const diagnose::Verdict& verdict) {
    return {{"finding", diagnose::to_string(verdict.finding)},
            {"finding_text", finding_text(verdict.finding)},
            {"adequate", verdict.finding == diagnose::Finding::Adequate},
            {"p_value", number(verdict.p_value)},
            {"reason", verdict.reason},
            {"tests", tests_json(verdict.tests)}};
}

/// The members that exist only for a model that could be fitted.
json compared_fit_json(const fit::Fit& model, const diagnose::Comparison& comparison) {
    const fit::RecordingFit& fit = model.parts.front();
    return {
        {"rmse_mm", number(1e3 * fit.rmse)},
        {"rmse_over_noise", number(comparison.over_noise)},
        {"reduced_chi2", number(model.reduced_chi_squared)},
        {"contradicted_inputs", contradictions_json(model.pulls)},
        {"degrees_of_freedom", fit.degrees_of_freedom},
        {"effective_degrees_of_freedom", number(comparison.verdict.effective_degrees_of_freedom)},
        {"parameters", parameters_json(fit.parameters)},
        {"verdict", verdict_json(comparison.verdict)},
        {"sentences", comparison_sentences(comparison)},
        {"where", where_json(comparison, fit)},
        {"remarks", fit.model.remarks}};
}

json ladder_model_json(const diagnose::Ladder& ladder, std::size_t k) {
    const diagnose::LadderModel& model = ladder.models[k];
    json out{{"model", model.fit.names()}, {"added", model.added}, {"runs", model.fit.batches}};
    if (k > 0) {
        out["compared_with"] = model.compared_with;
        out["gain"] = model.is_gain;
        out["why"] = model.why;
        out["step"] = fmt::format("{}", fmt::join(step_sentences(ladder, k), " "));
    }
    if (model.fit.failed()) {
        out["failure"] = model.fit.reason;
        return out;
    }
    out.update(compared_fit_json(model.fit, *model.comparison));
    out["moves"] = model.fit.moves();
    out["log_evidence"] = number(model.log_evidence);
    if (k > 0) {
        out["log_evidence_gain"] = number(model.log_evidence_gain);
        out["change"] = {{"bond_youngs_modulus", number(model.modulus_change)},
                         {"bond_damping", number(model.damping_change)}};
    }
    return out;
}

} // namespace

json against_amplitude_json(const std::vector<residuals::SwingWindow>& windows,
                            reduce::Estimate residuals::WindowFit::*quantity) {
    json out = json::array();
    for (const residuals::SwingWindow& window : windows)
        if (window.measured)
            out.push_back({{"amplitude_mm", number(millimetres * window.measured->amplitude)},
                           {"measured", bare_estimate(*window.measured.*quantity)},
                           {"modelled",
                            window.modelled ? bare_estimate(*window.modelled.*quantity) : json()}});
    return out;
}

json where_json(const diagnose::Comparison& comparison, const fit::RecordingFit& of) {
    return {{"by_height", groups_json(comparison.by_height, "height_mm", "", millimetres)},
            {"by_time", groups_json(comparison.by_time, "begin_s", "end_s", 1.0)},
            {"by_amplitude",
             groups_json(comparison.by_amplitude, "smallest_mm", "largest_mm", millimetres)},
            {"spectrum", spectrum_json(comparison.spectrum)},
            {"against_amplitude", array_of(comparison.windows, window_json)},
            {"banding", banding_json(comparison)},
            {"structure", structure_json(comparison.structure)},
            {"pattern_over_heights",
             {{"share", number(comparison.verdict.spatial_share)},
              {"rms_mm", millimetres_of(comparison.verdict.spatial_pattern)}}},
            {"residual_map", residual_map(of)}};
}

json comparison_json(const diagnose::Ladder& ladder, const measure::Measurement& measurement) {
    json out{
        {"format", "culm-comparison"},
        {"version", 1},
        {"measurement", measurement.stem.id},
        {"frames", measurement.times.size()},
        {"heights", measurement.heights.size()},
        {"ladder", array_of_count(ladder.models.size(),
                                  [&](std::size_t k) { return ladder_model_json(ladder, k); })},
        {"headline", comparison_headline(ladder, measurement.stem.id)},
        {"best", best_model(ladder)},
        {"remarks", measurement.remarks}};
    for (const diagnose::LadderModel& model : ladder.models)
        if (!model.fit.failed()) {
            out["noise_mm"] = number(1e3 * fit::typical_noise(model.fit.parts.front()));
            out["noise_source"] = model.fit.parts.front().noise_source;
            out["noise_known"] = model.fit.parts.front().is_noise_known;
        }
    return out;
}

} // namespace culm::present
