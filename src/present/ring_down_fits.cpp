// SPDX-License-Identifier: BSD-3-Clause
#include "present/ring_down_fits.hpp"

#include "present/files.hpp"
#include "present/parameters.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

namespace culm::present {
namespace {

using nlohmann::json;

json adequacy(const reduce::RingDownAdequacy& judged) {
    return {{"adequate", judged.is_adequate},
            {"reason", judged.reason},
            {"ljung_box_p_value", number(judged.ljung_box_p_value)},
            {"runs_p_value", number(judged.runs_p_value)},
            {"reduced_chi2", number(judged.reduced_chi_squared)},
            {"chi2_p_value", number(judged.chi_squared_p_value)}};
}

/// If Eq. 1 could not be fitted to a height, its entry contains the reason.
json height_json(const reduce::HeightRingDown& height, bool has_offset, bool has_phase) {
    json out{{"height_mm", 1e3 * height.height}};
    if (!height.fit) {
        out["failure"] = height.failure;
        return out;
    }
    const reduce::RingDownFit& fit = *height.fit;
    out["samples"] = fit.samples;
    out["b0_mm"] = interval_json(fit.amplitude, 1e3);
    out["b1_per_s"] = interval_json(fit.decay_rate);
    out["b1_per_cycle"] = interval_json(fit.decay_per_cycle);
    out["b1_per_cycle_stderr_if_independent"] = number(fit.independent_decay_error);
    out["b2_hz"] = interval_json(fit.frequency);
    if (has_offset)
        out["offset_mm"] = interval_json(fit.offset, 1e3);
    if (has_phase)
        out["phase_rad"] = interval_json(fit.phase);
    out["largest_deflection_mm"] = number(1e3 * fit.largest_deflection);
    out["rms_residual_mm"] = number(1e3 * fit.rms_residual);
    out["r_squared"] = number(fit.r_squared);
    out.update(adequacy(fit.adequacy));
    return out;
}

/// Null if a line has no points, for example the banding of a stem with one height.
json line_json(const reduce::LineFit& line) {
    if (line.count == 0)
        return nullptr;
    return {{"points", line.count},
            {"intercept", number(line.intercept)},
            {"slope", number(line.slope)},
            {"stderr", number(line.slope_error)},
            {"interval", bounds_json(line.slope_interval)},
            {"correlation", number(line.correlation)},
            {"p_value", number(line.p_value)}};
}

json stem_json(const FitReport& report, std::size_t i) {
    const reduce::StemRingDowns& stem = report.stems[i];
    const auto one_height = [&](const reduce::HeightRingDown& height) {
        return height_json(height, report.has_offset[i], report.options.has_phase);
    };
    json out{{"measurement", stem.id},
             {"folder", report.folders[i]},
             {"length_mm", 1e3 * stem.length},
             {"aspect_ratio", number(stem.aspect_ratio)},
             {"largest_deflection_mm", number(1e3 * stem.largest_deflection)},
             {"has_offset", bool(report.has_offset[i])},
             {"adequate_heights", stem.adequate_heights},
             {"heights", array_of(stem.heights, one_height)}};
    if (!stem.frequency || !stem.decay_per_cycle)
        return out;
    // With δ the logarithmic decrement, ζ/√(1 − ζ²) = δ/2π and ω₀ = ω_d √(1 + (δ/2π)²).
    const double decay = -stem.decay_per_cycle->value / (2.0 * std::numbers::pi);
    const double critical = std::hypot(1.0, decay);
    out["b1_per_cycle"] = interval_json(*stem.decay_per_cycle);
    out["b2_hz"] = interval_json(*stem.frequency);
    out["damping_ratio"] = number(decay / critical);
    out["natural_frequency_hz"] = number(stem.frequency->value * critical);
    out["banding"] = stem.banding ? line_json(*stem.banding) : json(nullptr);
    if (stem.banding)
        out["banding"]["p_value_adjusted"] = number(stem.banding_adjusted_p_value);
    return out;
}

json sample_with_histogram(const reduce::SampleSummary& sample, double scale = 1.0) {
    json out = sample_json(sample, scale);
    out["count"] = sample.count;
    out["histogram"] = {
        {"edges", array_of(sample.histogram.edges, [=](double edge) { return scale * edge; })},
        {"counts", sample.histogram.counts}};
    return out;
}

json laboratory_json(const reduce::PopulationSummary& population) {
    return {{"stems", population.stems},
            {"b1_per_cycle", sample_with_histogram(population.decay_per_cycle)},
            {"b2_hz", sample_with_histogram(population.frequency)},
            {"natural_frequency_hz", sample_with_histogram(population.natural_frequency)},
            {"largest_deflection_mm", sample_with_histogram(population.largest_deflection, 1e3)},
            {"length_mm", sample_with_histogram(population.length, 1e3)},
            {"aspect_ratio", sample_with_histogram(population.aspect_ratio)},
            {"b1_against_aspect_ratio", line_json(population.decay_against_aspect_ratio)},
            {"b1_against_relative_height", line_json(population.decay_against_height)},
            {"banding",
             {{"slopes", sample_with_histogram(population.banding_slopes)},
              {"mean_slope_p_value", number(population.mean_slope_p_value)},
              {"significant_stems", population.banded_stems}}}};
}

// A screen has some 40 lines; for more stems than this only the population is shown.
constexpr std::size_t most_stems = 30;

std::string plus_minus(const reduce::Estimate& found) {
    return with_uncertainty(found.value, found.upper - found.value);
}

std::string p_text(double p) {
    return p < 1e-4 ? std::string("< 0.0001") : fmt::format("{:.4f}", p);
}

std::string stem_heights(const reduce::StemRingDowns& stem, const TextStyle& style) {
    std::string text = fmt::format("{}: Eq. 1 at each height (intervals 95 %)\n{:>8} {:>9} {:>20} "
                                   "{:>20} {:>22} {:>9}  {}\n",
                                   stem.id, "h mm", "b0 " + stem.unit.name, "b1 per cycle",
                                   "b1 1/s", "b2 Hz", "rms " + stem.unit.name, "adequate");
    for (const reduce::HeightRingDown& height : stem.heights) {
        if (!height.fit) {
            text += fmt::format("{:8.1f} {}: {}\n", 1e3 * height.height, style.failure("no fit"),
                                height.failure);
            continue;
        }
        const reduce::RingDownFit& fit = *height.fit;
        text += fmt::format("{:8.1f} {:9.3f} {:>20} {:>20} {:>22} {:9.4f}  {}\n",
                            1e3 * height.height, stem.unit.factor * fit.amplitude.value,
                            plus_minus(fit.decay_per_cycle), plus_minus(fit.decay_rate),
                            plus_minus(fit.frequency), stem.unit.factor * fit.rms_residual,
                            fit.adequacy.is_adequate ? style.good("yes")
                                                     : style.warning("no: ") + fit.adequacy.reason);
    }
    if (stem.frequency)
        text += fmt::format("{:>8} {:>9} {:>20} {:>20} {:>22}\n", "mean", "",
                            plus_minus(*stem.decay_per_cycle), "", plus_minus(*stem.frequency));
    if (stem.banding)
        text += fmt::format("banding: b1 per cycle changes by {:.4f} from the clamp to the tip "
                            "(95 %: {:.4f} … {:.4f}, p {})\n",
                            stem.banding->slope, stem.banding->slope_interval.lower,
                            stem.banding->slope_interval.upper, p_text(stem.banding->p_value));
    return text;
}

std::string stem_lines(const FitReport& report) {
    std::string text =
        fmt::format("Eq. 1, means over the heights (intervals 95 %)\n{:<14} {:>18} {:>18} {:>8} "
                    "{:>10} {:>16} {:>8}\n",
                    "stem", "b1 per cycle", "b2 Hz", "tip mm", "adequate", "banding slope", "p");
    for (const reduce::StemRingDowns& stem : report.stems) {
        if (!stem.frequency) {
            text += fmt::format("{:<14} no height could be fitted: {}\n", stem.id,
                                stem.heights.empty() ? "" : stem.heights.back().failure);
            continue;
        }
        text += fmt::format("{:<14} {:>18} {:>18} {:8.2f} {:>10} {:>16} {:>8}\n", stem.id,
                            plus_minus(*stem.decay_per_cycle), plus_minus(*stem.frequency),
                            1e3 * stem.largest_deflection,
                            fmt::format("{}/{}", stem.adequate_heights, stem.heights.size()),
                            stem.banding ? fmt::format("{:.4f}", stem.banding->slope) : "-",
                            stem.banding ? p_text(stem.banding_adjusted_p_value) : "-");
    }
    return text;
}

std::string sample_line(const char* name, const reduce::SampleSummary& sample, double scale) {
    return fmt::format("{:<22} mean {:9.4f} ({:.4f} … {:.4f})   sd {:8.4f} ({:.4f} … {:.4f})   "
                       "{:.4f} … {:.4f}\n",
                       name, scale * sample.mean, scale * sample.mean_interval.lower,
                       scale * sample.mean_interval.upper, scale * sample.standard_deviation,
                       scale * sample.standard_deviation_interval.lower,
                       scale * sample.standard_deviation_interval.upper, scale * sample.lowest,
                       scale * sample.highest);
}

std::string population_lines(const reduce::PopulationSummary& population) {
    std::string text =
        fmt::format("{} stems (intervals 95 %; lowest … highest)\n", population.stems);
    text += sample_line("b1 per cycle", population.decay_per_cycle, 1.0);
    text += sample_line("b2, Hz", population.frequency, 1.0);
    text += sample_line("undamped frequency, Hz", population.natural_frequency, 1.0);
    text += sample_line("largest deflection, mm", population.largest_deflection, 1e3);
    const reduce::LineFit& aspect = population.decay_against_aspect_ratio;
    if (aspect.count > 0)
        text += fmt::format("b1 against aspect ratio: correlation {:.2f}, p {}\n",
                            aspect.correlation, p_text(aspect.p_value));
    if (population.banding_slopes.count > 1)
        text +=
            fmt::format("banding: mean slope {:.4f} per relative height, p {} over stems; {} of "
                        "{} stems significant after Holm's adjustment\n",
                        population.banding_slopes.mean, p_text(population.mean_slope_p_value),
                        population.banded_stems, population.banding_slopes.count);
    return text;
}

/// Advice for the case that Eq. 1 is inadequate at most heights.
std::string advice(const FitReport& report) {
    std::size_t fitted = 0;
    std::size_t adequate = 0;
    for (const reduce::StemRingDowns& stem : report.stems) {
        fitted += static_cast<std::size_t>(std::ranges::count_if(
            stem.heights, [](const auto& height) { return bool(height.fit); }));
        adequate += stem.adequate_heights;
    }
    if (2 * adequate >= fitted)
        return "";
    return fmt::format(
        "Eq. 1 explains {} of {} heights to within their noise{}\n", adequate, fitted,
        report.options.has_phase ? ""
                                 : "; --phase free lets it start at rest, as a held stem does");
}

} // namespace

json fit_json(const FitReport& report) {
    const auto one_stem = [&report](std::size_t i) { return stem_json(report, i); };
    return {{"format", "culm-fit"},
            {"version", 1},
            {"model",
             {{"phase", report.options.has_phase ? "free" : "fixed"},
              {"window_s", number(report.options.window)}}},
            {"stems", array_of_count(report.stems.size(), one_stem)},
            {"population", report.population ? laboratory_json(*report.population) : json(nullptr)},
            {"remarks", report.remarks}};
}

std::string fit_table(const FitReport& report, const TextStyle& style) {
    std::string text;
    if (report.stems.size() == 1)
        text = stem_heights(report.stems.front(), style);
    else if (report.stems.size() <= most_stems)
        text = stem_lines(report);
    if (report.population)
        text += population_lines(*report.population);
    return text + advice(report);
}

std::string fit_csv(const FitReport& report) {
    std::string text = "measurement,height_mm,samples,b0_mm,b1_per_s,b1_per_cycle,"
                       "b1_per_cycle_stderr,b2_hz,b2_hz_stderr,rms_residual_mm,adequate\n";
    for (const reduce::StemRingDowns& stem : report.stems)
        for (const reduce::HeightRingDown& height : stem.heights) {
            if (!height.fit)
                continue;
            const reduce::RingDownFit& fit = *height.fit;
            text += fmt::format("\"{}\",{:.10g},{},{},{},{},{},{},{},{},{}\n", stem.id,
                                1e3 * height.height, fit.samples, 1e3 * fit.amplitude.value,
                                fit.decay_rate.value, fit.decay_per_cycle.value,
                                fit.decay_per_cycle.standard_error, fit.frequency.value,
                                fit.frequency.standard_error, 1e3 * fit.rms_residual,
                                fit.adequacy.is_adequate ? 1 : 0);
        }
    return text;
}

} // namespace culm::present
