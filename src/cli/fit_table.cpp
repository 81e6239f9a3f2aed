// SPDX-License-Identifier: BSD-3-Clause
#include "cli/fit_table.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace culm::cli {
namespace {

// A screen has some 40 lines; of more stems than these only the population is shown.
constexpr std::size_t most_stems = 30;

std::string plus_minus(const reduce::Estimate& found, int decimals) {
    return fmt::format("{:.{}f} ± {:.{}f}", found.value, decimals, found.upper - found.value,
                       decimals);
}

std::string p_text(double p) {
    return p < 1e-4 ? std::string("< 0.0001") : fmt::format("{:.4f}", p);
}

std::string stem_heights(const reduce::StemRingDowns& stem, const TextStyle& style) {
    std::string text = fmt::format("{}: Eq. 1 at each height (intervals 95 %)\n{:>8} {:>9} {:>20} "
                                   "{:>20} {:>22} {:>9}  {}\n",
                                   stem.id, "h mm", "b0 mm", "b1 per cycle", "b1 1/s", "b2 Hz",
                                   "rms mm", "adequate");
    for (const reduce::HeightRingDown& height : stem.heights) {
        if (!height.fit) {
            text += fmt::format("{:8.1f} {}: {}\n", 1e3 * height.height, style.failure("no fit"),
                                height.failure);
            continue;
        }
        const reduce::RingDownAnalysis& fit = *height.fit;
        text += fmt::format("{:8.1f} {:9.3f} {:>20} {:>20} {:>22} {:9.4f}  {}\n",
                            1e3 * height.height, 1e3 * fit.amplitude.value,
                            plus_minus(fit.decay_per_cycle, 4), plus_minus(fit.decay_rate, 2),
                            plus_minus(fit.frequency, 3), 1e3 * fit.rms_residual,
                            fit.adequacy.is_adequate ? style.good("yes")
                                                     : style.warning("no: ") + fit.adequacy.reason);
    }
    if (stem.frequency)
        text +=
            fmt::format("{:>8} {:>9} {:>20} {:>20} {:>22}\n", "mean", "",
                        plus_minus(*stem.decay_per_cycle, 4), "", plus_minus(*stem.frequency, 3));
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
                            plus_minus(*stem.decay_per_cycle, 4), plus_minus(*stem.frequency, 3),
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

/// What to do where Eq. 1 does not suffice at most heights.
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
            const reduce::RingDownAnalysis& fit = *height.fit;
            text += fmt::format("\"{}\",{:.10g},{},{},{},{},{},{},{},{},{}\n", stem.id,
                                1e3 * height.height, fit.samples, 1e3 * fit.amplitude.value,
                                fit.decay_rate.value, fit.decay_per_cycle.value,
                                fit.decay_per_cycle.standard_error, fit.frequency.value,
                                fit.frequency.standard_error, 1e3 * fit.rms_residual,
                                fit.adequacy.is_adequate ? 1 : 0);
        }
    return text;
}

} // namespace culm::cli
