// SPDX-License-Identifier: BSD-3-Clause
#include "cli/fit_json.hpp"

#include "present/json.hpp"

#include <cmath>
#include <numbers>

namespace culm::cli {

using present::number;
namespace {

using nlohmann::json;

json number(const std::optional<double>& value) {
    return value ? cli::number(*value) : json(nullptr);
}

json bounds(const reduce::Bounds& interval, double scale = 1.0) {
    return json::array({number(scale * interval.lower), number(scale * interval.upper)});
}

json estimate(const reduce::Estimate& found, double scale = 1.0) {
    return {{"value", number(scale * found.value)},
            {"stderr", number(scale * found.standard_error)},
            {"interval", json::array({number(scale * found.lower), number(scale * found.upper)})}};
}

json adequacy(const reduce::RingDownAdequacy& judged) {
    return {{"adequate", judged.is_adequate},
            {"reason", judged.reason},
            {"ljung_box_p_value", number(judged.ljung_box_p_value)},
            {"runs_p_value", number(judged.runs_p_value)},
            {"reduced_chi2", number(judged.reduced_chi_squared)},
            {"chi2_p_value", number(judged.chi_squared_p_value)}};
}

json height_json(const reduce::HeightRingDown& height, bool has_offset, bool has_phase) {
    json out{{"height_mm", 1e3 * height.height}};
    if (!height.fit) {
        out["failure"] = height.failure;
        return out;
    }
    const reduce::RingDownAnalysis& fit = *height.fit;
    out["samples"] = fit.samples;
    out["b0_mm"] = estimate(fit.amplitude, 1e3);
    out["b1_per_s"] = estimate(fit.decay_rate);
    out["b1_per_cycle"] = estimate(fit.decay_per_cycle);
    out["b1_per_cycle_stderr_if_independent"] = number(fit.independent_decay_error);
    out["b2_hz"] = estimate(fit.frequency);
    if (has_offset)
        out["offset_mm"] = estimate(fit.offset, 1e3);
    if (has_phase)
        out["phase_rad"] = estimate(fit.phase);
    out["largest_deflection_mm"] = number(1e3 * fit.largest_deflection);
    out["rms_residual_mm"] = number(1e3 * fit.rms_residual);
    out["r_squared"] = number(fit.r_squared);
    out.update(adequacy(fit.adequacy));
    return out;
}

json line_json(const reduce::LineFit& line) {
    if (line.count == 0)
        return nullptr;
    return {{"points", line.count},
            {"intercept", number(line.intercept)},
            {"slope", number(line.slope)},
            {"stderr", number(line.slope_error)},
            {"interval", bounds(line.slope_interval)},
            {"correlation", number(line.correlation)},
            {"p_value", number(line.p_value)}};
}

json stem_json(const reduce::StemRingDowns& stem, const std::string& folder, bool has_offset,
               bool has_phase) {
    json heights = json::array();
    for (const reduce::HeightRingDown& height : stem.heights)
        heights.push_back(height_json(height, has_offset, has_phase));
    json out{{"measurement", stem.id},
             {"folder", folder},
             {"length_mm", 1e3 * stem.length},
             {"aspect_ratio", number(stem.aspect_ratio)},
             {"largest_deflection_mm", number(1e3 * stem.largest_deflection)},
             {"has_offset", has_offset},
             {"adequate_heights", stem.adequate_heights},
             {"heights", heights}};
    if (!stem.frequency || !stem.decay_per_cycle)
        return out;
    const double decay = -stem.decay_per_cycle->value / (2.0 * std::numbers::pi);
    const double critical = std::hypot(1.0, decay);
    out["b1_per_cycle"] = estimate(*stem.decay_per_cycle);
    out["b2_hz"] = estimate(*stem.frequency);
    out["damping_ratio"] = number(decay / critical);
    out["natural_frequency_hz"] = number(stem.frequency->value * critical);
    out["banding"] = stem.banding ? line_json(*stem.banding) : json(nullptr);
    if (stem.banding)
        out["banding"]["p_value_adjusted"] = number(stem.banding_adjusted_p_value);
    return out;
}

json sample_json(const reduce::SampleSummary& sample, double scale = 1.0) {
    json edges = json::array();
    for (const double edge : sample.histogram.edges)
        edges.push_back(scale * edge);
    return {{"count", sample.count},
            {"mean", number(scale * sample.mean)},
            {"mean_interval", bounds(sample.mean_interval, scale)},
            {"standard_deviation", number(scale * sample.standard_deviation)},
            {"standard_deviation_interval", bounds(sample.standard_deviation_interval, scale)},
            {"lowest", number(scale * sample.lowest)},
            {"median", number(scale * sample.median)},
            {"highest", number(scale * sample.highest)},
            {"central_90_percent", bounds(sample.central_90_percent, scale)},
            {"histogram", {{"edges", edges}, {"counts", sample.histogram.counts}}}};
}

json population_json(const reduce::PopulationSummary& population) {
    return {{"stems", population.stems},
            {"b1_per_cycle", sample_json(population.decay_per_cycle)},
            {"b2_hz", sample_json(population.frequency)},
            {"natural_frequency_hz", sample_json(population.natural_frequency)},
            {"largest_deflection_mm", sample_json(population.largest_deflection, 1e3)},
            {"length_mm", sample_json(population.length, 1e3)},
            {"aspect_ratio", sample_json(population.aspect_ratio)},
            {"b1_against_aspect_ratio", line_json(population.decay_against_aspect_ratio)},
            {"b1_against_relative_height", line_json(population.decay_against_height)},
            {"banding",
             {{"slopes", sample_json(population.banding_slopes)},
              {"mean_slope_p_value", number(population.mean_slope_p_value)},
              {"significant_stems", population.banded_stems}}}};
}

} // namespace

json fit_json(const FitReport& report) {
    json stems = json::array();
    for (std::size_t i = 0; i < report.stems.size(); ++i)
        stems.push_back(stem_json(report.stems[i], report.folders[i], report.has_offset[i],
                                  report.options.has_phase));
    return {{"format", "culm-fit"},
            {"version", 1},
            {"model",
             {{"phase", report.options.has_phase ? "free" : "fixed"},
              {"window_s", number(report.options.window)}}},
            {"stems", stems},
            {"population", report.population ? population_json(*report.population) : json(nullptr)},
            {"remarks", report.remarks}};
}

} // namespace culm::cli
