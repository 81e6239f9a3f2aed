// SPDX-License-Identifier: BSD-3-Clause
#include "present/ring_down_fits.hpp"

#include "present/parameters.hpp"
#include "present/text.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include <fmt/format.h>

namespace culm::present {
namespace {

using nlohmann::json;

/// If Eq. 1 could not be fitted to a height, its entry contains the reason.
template <class To>
void describe_height(To& to, const residuals::HeightRingDown& height, bool has_offset,
                     bool has_phase) {
    to("height_mm", height.height);
    to.when(!height.fit, [&] { to("failure", height.failure); });
    to.when(height.fit, [&](const reduce::RingDownFit& fit) {
        to("samples", fit.samples);
        to("b0_mm", fit.amplitude);
        to("b1_per_s", fit.decay_rate);
        to("b1_per_cycle", fit.decay_per_cycle);
        to("b1_per_cycle_stderr_if_independent", fit.independent_decay_error);
        to("b2_hz", fit.frequency);
        to.when(has_offset, [&] { to("offset_mm", fit.offset); });
        to.when(has_phase, [&] { to("phase_rad", fit.phase); });
        to("largest_deflection_mm", fit.largest_deflection);
        to("rms_residual_mm", fit.rms_residual);
        to("r_squared", fit.r_squared);
        to("adequate", fit.adequacy.is_adequate);
        to("reason", fit.adequacy.reason);
        to("ljung_box_p_value", fit.adequacy.ljung_box_p_value);
        to("runs_p_value", fit.adequacy.runs_p_value);
        to("reduced_chi2", fit.adequacy.reduced_chi_squared);
        to("chi2_p_value", fit.adequacy.chi_squared_p_value);
    });
}

/// Means over the heights.
template <class To>
void describe_means(To& to, const residuals::StemRingDowns& stem) {
    // With δ the logarithmic decrement, ζ/√(1 − ζ²) = δ/2π and ω₀ = ω_d √(1 + (δ/2π)²).
    const auto decay = [&] { return -stem.decay_per_cycle->value / (2.0 * std::numbers::pi); };
    const auto critical = [&] { return std::hypot(1.0, decay()); };
    to("b1_per_cycle", [&] { return *stem.decay_per_cycle; });
    to("b2_hz", [&] { return *stem.frequency; });
    to("damping_ratio", [&] { return decay() / critical(); });
    to("natural_frequency_hz", [&] { return stem.frequency->value * critical(); });
    to.maybe(
        "banding", stem.banding && stem.banding->count > 0,
        [&] {
            describe(to, stem.banding.value_or(reduce::LineFit()));
            to("p_value_adjusted", stem.banding_adjusted_p_value, "for the number of stems");
        },
        "b1 per cycle along the relative height");
}

template <class To>
void describe_stem(To& to, const FitReport& report, const FittedStem& fitted) {
    const residuals::StemRingDowns& stem = fitted.ring_downs;
    to("measurement", stem.id);
    to("folder", fitted.folder);
    to("length_mm", stem.length);
    to("aspect_ratio", stem.aspect_ratio);
    to("largest_deflection_mm", stem.largest_deflection);
    to("has_offset", fitted.has_offset);
    to("adequate_heights", stem.adequate_heights);
    to.list("heights", stem.heights, [&](const residuals::HeightRingDown& height) {
        describe_height(to, height, fitted.has_offset, report.options.has_phase);
    });
    to.when(stem.frequency && stem.decay_per_cycle, [&] { describe_means(to, stem); });
    to.when(report.has_backbones, [&] { to("backbone", fitted.backbones); });
    to.when(report.has_modes, [&] { to("modes", fitted.modes); });
}

template <class To>
void describe_population(To& to, const residuals::PopulationSummary& population) {
    // Null if a line has no points.
    const auto line = [&](const char* key, const reduce::LineFit& of) {
        to(key, [&] { return of.count > 0 ? std::optional(of) : std::nullopt; });
    };
    to("stems", population.stems);
    to("b1_per_cycle", population.decay_per_cycle);
    to("b2_hz", population.frequency);
    to("natural_frequency_hz", population.natural_frequency);
    to("largest_deflection_mm", population.largest_deflection);
    to("length_mm", population.length);
    to("aspect_ratio", population.aspect_ratio);
    line("b1_against_aspect_ratio", population.decay_against_aspect_ratio);
    line("b1_against_relative_height", population.decay_against_height);
    to.object("banding", [&] {
        to("slopes", population.banding_slopes);
        to("mean_slope_p_value", population.mean_slope_p_value);
        to("significant_stems", population.banded_stems, "after Holm's adjustment");
    });
}

} // namespace

/// fit.json.
template <class To>
void describe(To& to, const FitReport& report) {
    to.constant("format", "culm-fit");
    to.constant("version", 1);
    to.object("model", [&] {
        to("phase", [&] { return report.options.has_phase ? "free" : "fixed"; });
        to("window_s", report.options.window);
    });
    to.list("stems", report.stems,
            [&](const FittedStem& stem) { describe_stem(to, report, stem); });
    to.maybe("population", report.population,
             [&](const auto& population) { describe_population(to, population); });
    to("remarks", report.remarks);
    to("provenance", report.provenance);
}

namespace {

// A screen has some 40 lines; for more stems than this only the population is shown.
constexpr std::size_t most_stems = 30;

std::string p_text(double p) {
    return p < 1e-4 ? std::string("< 0.0001") : fmt::format("{:.4f}", p);
}

std::string stem_heights(const residuals::StemRingDowns& stem) {
    std::string text =
        fmt::format("{}: Eq. 1 at each height (intervals 95 %)\n{:>8} {:>9} {:>20} "
                    "{:>20} {:>22} {:>9}  {}\n",
                    stem.id, "h mm", fmt::format("b0 {}", stem.unit.name), "b1 per cycle", "b1 1/s",
                    "b2 Hz", fmt::format("rms {}", stem.unit.name), "adequate");
    for (const residuals::HeightRingDown& height : stem.heights) {
        if (!height.fit) {
            text += fmt::format("{:8.1f} {}: {}\n", 1e3 * height.height, "no fit", height.failure);
            continue;
        }
        const reduce::RingDownFit& fit = *height.fit;
        text += fmt::format("{:8.1f} {:9.3f} {:>20} {:>20} {:>22} {:9.4f}  {}\n",
                            1e3 * height.height, stem.unit.factor * fit.amplitude.value,
                            plus_minus(fit.decay_per_cycle), plus_minus(fit.decay_rate),
                            plus_minus(fit.frequency), stem.unit.factor * fit.rms_residual,
                            fit.adequacy.is_adequate ? std::string("yes")
                                                     : "no: " + fit.adequacy.reason);
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
    for (const FittedStem& fitted : report.stems) {
        const residuals::StemRingDowns& stem = fitted.ring_downs;
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

std::string population_lines(const residuals::PopulationSummary& population) {
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
    for (const FittedStem& stem : report.stems) {
        fitted += static_cast<std::size_t>(std::ranges::count_if(
            stem.ring_downs.heights, [](const auto& height) { return bool(height.fit); }));
        adequate += stem.ring_downs.adequate_heights;
    }
    if (2 * adequate >= fitted)
        return "";
    return fmt::format(
        "Eq. 1 explains {} of {} heights to within their noise{}\n", adequate, fitted,
        report.options.has_phase ? ""
                                 : "; --phase free lets it start at rest, as a held stem does");
}

/// "0.0039 (0.0036 … 0.0042)"
std::string with_interval(const reduce::Estimate& of, double unit = 1.0) {
    return fmt::format("{:.4g} ({:.4g} … {:.4g})", unit * of.value, unit * of.lower,
                       unit * of.upper);
}

/// The laws of a mode, as simulators take them. `unit`: of amplitudes.
std::string law_lines(const reduce::AmplitudeLaws& laws, const measure::ReadingUnit& unit) {
    const double reference = unit.factor * laws.reference;
    const std::string over = fmt::format("(A/{:.4g} {})", reference, unit.name);
    std::string text = "  damping ratio, 95 %: ζ0 " + with_interval(*laws.linear);
    if (laws.coulomb)
        text += fmt::format(" + c/A, c {} {}", with_interval(*laws.coulomb, reference), unit.name);
    if (laws.power)
        text += fmt::format(" + ζ1 {}^p, ζ1 {}, p {}", over, with_interval(*laws.power),
                            with_interval(*laws.power_exponent));
    text += fmt::format("\n  frequency, 95 %: f0 {} Hz", with_interval(laws.frequency));
    if (laws.softening)
        text += fmt::format(", (1 - ε {}^q), ε {}, q {}", over, with_interval(*laws.softening),
                            with_interval(*laws.softening_exponent));
    return text + fmt::format("\n  decrement per cycle P + Q A, 95 %: P {}, Q {} 1/{}\n",
                              with_interval(laws.decrement),
                              with_interval(laws.quadratic_decrement, 1.0 / reference), unit.name);
}

/// The backbones of a stem; strains are printed in mm/m.
std::string backbone_lines(const FittedStem& stem) {
    constexpr std::size_t most_lines = 12;
    const std::string& id = stem.ring_downs.id;
    if (stem.backbones.empty())
        return id + ": no mode stands out of the readings, so there is no backbone\n";
    std::string text;
    for (const reduce::ModeBackbone& backbone : stem.backbones) {
        const measure::ReadingUnit unit{1e3, backbone.is_strain ? "mm/m" : "mm"};
        text += fmt::format("{}: backbone of mode {}, A at h = {:.1f} mm (intervals 95 %)\n", id,
                            backbone.mode, 1e3 * backbone.height);
        const std::size_t step = (backbone.points.size() + most_lines - 1) / most_lines;
        if (!backbone.points.empty())
            text += fmt::format("{:>10} {:>22} {:>22}\n", fmt::format("A {}", unit.name),
                                "frequency Hz", "damping ratio");
        for (std::size_t k = 0; k < backbone.points.size(); k += std::max<std::size_t>(step, 1)) {
            const reduce::BackbonePoint& point = backbone.points[k];
            text += fmt::format("{:10.4g} {:>22} {:>22}\n", unit.factor * point.amplitude,
                                with_uncertainty(point.frequency, 1.96 * point.frequency_error),
                                with_uncertainty(point.damping_ratio, 1.96 * point.damping_error));
        }
        text += backbone.laws ? law_lines(*backbone.laws, unit)
                              : "  no laws: " + backbone.reason + "\n";
        if (backbone.signature)
            text += "  " + reduce::sentence(*backbone.signature) + "\n";
    }
    return text;
}

std::string mode_lines(const FittedStem& fitted) {
    const residuals::StemRingDowns& stem = fitted.ring_downs;
    if (!fitted.modes)
        return stem.id + ": no damped modes could be fitted together\n";
    std::string text =
        fmt::format("{}: {} at all heights together (intervals 95 %)\n"
                    "{:>6} {:>22} {:>22} {:>14}\n",
                    stem.id, counted(fitted.modes->modes.size(), "damped mode"), "mode",
                    "frequency Hz", "damping ratio", fmt::format("A {}", stem.unit.name));
    for (std::size_t k = 0; k < fitted.modes->modes.size(); ++k) {
        const reduce::DampedMode& mode = fitted.modes->modes[k];
        double largest = 0.0;
        for (const std::complex<double>& amplitude : mode.amplitudes)
            largest = std::max(largest, std::abs(amplitude));
        text +=
            fmt::format("{:6} {:>22} {:>22} {:14.4g}\n", k + 1,
                        with_uncertainty(mode.rate.frequency, 1.96 * mode.frequency_error),
                        with_uncertainty(mode.damping_ratio(), 1.96 * mode.damping_ratio_error()),
                        stem.unit.factor * largest);
    }
    return text;
}

} // namespace

json fit_json(const FitReport& report) {
    return core::json_of(report);
}

json fit_schema() {
    return core::schema_of<FitReport>();
}

std::string fit_table(const FitReport& report) {
    std::string text;
    if (report.stems.size() == 1)
        text = stem_heights(report.stems.front().ring_downs);
    else if (report.stems.size() <= most_stems)
        text = stem_lines(report);
    if (report.population)
        text += population_lines(*report.population);
    if (report.has_modes)
        for (const FittedStem& stem : report.stems)
            text += mode_lines(stem);
    if (report.has_backbones)
        for (const FittedStem& stem : report.stems)
            text += backbone_lines(stem);
    return text + advice(report);
}

std::string fit_csv(const FitReport& report) {
    std::string text = "measurement,height_mm,samples,b0_mm,b1_per_s,b1_per_cycle,"
                       "b1_per_cycle_stderr,b2_hz,b2_hz_stderr,rms_residual_mm,adequate\n";
    for (const FittedStem& stem : report.stems)
        for (const residuals::HeightRingDown& height : stem.ring_downs.heights) {
            if (!height.fit)
                continue;
            const reduce::RingDownFit& fit = *height.fit;
            text += fmt::format("\"{}\",{:.10g},{},{},{},{},{},{},{},{},{}\n", stem.ring_downs.id,
                                1e3 * height.height, fit.samples, 1e3 * fit.amplitude.value,
                                fit.decay_rate.value, fit.decay_per_cycle.value,
                                fit.decay_per_cycle.standard_error, fit.frequency.value,
                                fit.frequency.standard_error, 1e3 * fit.rms_residual,
                                fit.adequacy.is_adequate ? 1 : 0);
        }
    return text;
}

} // namespace culm::present
