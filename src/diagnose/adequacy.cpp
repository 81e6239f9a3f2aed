// SPDX-License-Identifier: BSD-3-Clause
#include "diagnose/adequacy.hpp"

#include "core/error.hpp"
#include "reduce/population_statistics.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace culm::diagnose {
namespace {

/// The damping and the second mode cannot be determined from fewer than two cycles.
constexpr double fewest_cycles = 2.0;
/// A motion below three times its noise determines neither frequency nor damping.
constexpr double smallest_swing_over_noise = 3.0;
/// The tests' distributions are asymptotic; they are accurate to a few per cent from 30 readings.
constexpr std::size_t fewest_frames = 30;
/// Smallest excess of χ² over its mean, in standard deviations √(2n), of readings with motion.
constexpr double motion_over_noise = 5.0;

/// χ² of the readings above the noise, with the error terms; in m² if the noise is not known.
double misfit(const fit::Fit& fit) {
    return fit.is_noise_known_anywhere()
               ? std::max(0.0, fit.chi_squared - static_cast<double>(fit.readings))
               : fit.rmse * fit.rmse;
}

/// Why the recording does not permit a verdict; empty if it does.
std::string what_is_too_little(const fit::RecordingFit& fit, const residuals::Swing& swing) {
    double squares = 0.0;
    std::size_t frames = 0;
    for (std::size_t i = 0; i < swing.times.size(); ++i)
        if (swing.times[i] >= 0.0 && !std::isnan(swing.measured[i])) {
            squares += swing.measured[i] * swing.measured[i];
            ++frames;
        }
    if (frames < fewest_frames)
        return fmt::format("{} frames after the release are too few to decide; {} are needed",
                           frames, fewest_frames);
    if (const double cycles = fit.times.back() * swing.frequency; cycles < fewest_cycles)
        return fmt::format("{:.1f} cycles after the release are too few to decide; {} are needed",
                           cycles, fewest_cycles);
    const double size = std::sqrt(squares / static_cast<double>(frames));
    const measure::ReadingUnit unit = measure::reading_unit(fit.model.spec.sensors);
    if (fit.is_noise_known && size < smallest_swing_over_noise * swing.noise)
        return fmt::format(
            "the motion (rms {:.3g} {}) hardly exceeds the noise ({:.3g} {} with all "
            "heights together)",
            unit.factor * size, unit.name, unit.factor * swing.noise, unit.name);
    return {};
}

/// Holm (1979): the family of tests rejects falsely with at most the given level, even if the tests
/// are dependent. The power is larger than with Bonferroni's division.
void adjust(Verdict& verdict, const Policy& policy) {
    std::vector<double> p_values;
    for (const residuals::LackOfFitTest& test : verdict.tests)
        p_values.push_back(test.p_value);
    const std::vector<double> adjusted = reduce::holm_adjusted(p_values);
    for (std::size_t k = 0; k < adjusted.size(); ++k) {
        verdict.tests[k].adjusted_p_value = adjusted[k];
        verdict.p_value = std::min(verdict.p_value, adjusted[k]);
        if (adjusted[k] < policy.lack_of_fit_level)
            verdict.failed_tests.push_back(verdict.tests[k].name);
    }
    verdict.finding = verdict.failed_tests.empty() ? Finding::Adequate : Finding::Inadequate;
    verdict.reason = fmt::format("{}", fmt::join(verdict.failed_tests, ", "));
}

} // namespace

std::string_view to_string(Finding finding) {
    constexpr std::array names{"adequate", "inadequate", "undecided"};
    return names[static_cast<std::size_t>(finding)];
}

Verdict verdict_on(const fit::RecordingFit& fit, const residuals::Swing& swing,
                   const Policy& policy) {
    Verdict verdict;
    static_cast<residuals::LackOfFit&>(verdict) = residuals::test_lack_of_fit(fit, swing);
    verdict.is_noise_known = fit.is_noise_known;
    verdict.reduced_chi_squared = fit.reduced_chi_squared;
    // The tests are computed in every case, because the report shows them.
    adjust(verdict, policy);
    if (std::string reason = what_is_too_little(fit, swing); !reason.empty()) {
        verdict.finding = Finding::Undecided;
        verdict.reason = std::move(reason);
    }
    return verdict;
}

SetVerdict verdict_on(const fit::Fit& fit, std::span<const fit::ObservedRecording> recordings,
                      const Policy& policy) {
    SetVerdict out;
    out.finding = Finding::Adequate;
    bool can_tell = false;
    for (std::size_t m = 0; m < fit.parts.size(); ++m) {
        const Verdict own =
            verdict_on(fit.parts[m], residuals::swing_of(fit.parts[m], recordings[m]), policy);
        if (own.finding == Finding::Undecided) {
            if (!can_tell)
                out.reason = own.reason;
            continue;
        }
        if (!can_tell)
            out.reason.clear();
        can_tell = true;
        const double p =
            std::min(1.0, own.p_value * static_cast<double>(fit.parts.size())); // Bonferroni
        out.p_value = std::min(out.p_value, p);
        if (p >= policy.lack_of_fit_level)
            continue;
        out.finding = Finding::Inadequate;
        if (!out.reason.empty())
            out.reason += "; ";
        out.reason += own.reason;
    }
    if (!can_tell)
        out.finding = Finding::Undecided;
    return out;
}

bool has_structure(const fit::Fit& fit, const SetVerdict& verdict, const Policy& policy) {
    const auto readings = static_cast<double>(std::max<std::size_t>(fit.readings, 1));
    const bool is_above_noise = !fit.is_noise_known_anywhere() ||
                                std::sqrt(misfit(fit) / readings) > policy.immaterial_noise;
    return is_above_noise && verdict.finding == Finding::Inadequate;
}

double explained_share(const fit::Fit& fit, const fit::Fit& first) {
    double all = 0.0;
    double followed = 0.0;
    for (const fit::RecordingMisfit& each : first.misfits) {
        all += each.chi_squared;
        followed += each.chi_squared / std::max(1.0, each.over_followed());
    }
    const double before = all > 0.0 ? misfit(first) * followed / all : 0.0;
    return before > 0.0 ? std::clamp(1.0 - misfit(fit) / before, 0.0, 1.0) : 0.0;
}

bool leaves_too_much(const fit::Fit& fit, const SetVerdict& verdict, const fit::Fit& first,
                     const Policy& policy) {
    return 1.0 - explained_share(fit, first) > policy.unexplained_share &&
           has_structure(fit, verdict, policy);
}

void refuse_without_motion(const measure::Measurement& measurement, std::optional<double> window) {
    const double end = window.value_or(std::numeric_limits<double>::infinity());
    double chi_squared = 0.0;
    double squares = 0.0;
    double noise_squares = 0.0;
    double readings = 0.0;
    for (std::size_t i = 0; i < measurement.times.size(); ++i)
        for (std::size_t j = 0; j < measurement.heights.size(); ++j) {
            const double reading = measurement.deflection(i, j);
            const std::optional<double> noise = measurement.noise_at(j);
            if (measurement.times[i] < 0.0 || measurement.times[i] > end || std::isnan(reading) ||
                !noise)
                continue;
            chi_squared += std::pow(reading / *noise, 2);
            squares += reading * reading;
            noise_squares += *noise * *noise;
            readings += 1.0;
        }
    const measure::ReadingUnit unit = measure::reading_unit(measurement.sensors);
    // χ² of n readings of pure noise has the mean n and the standard deviation √(2n).
    if (readings > 0.0 && chi_squared - readings < motion_over_noise * std::sqrt(2.0 * readings))
        throw core::InputError(fmt::format(
            "{}: the readings after the release (rms {:.3g} {}) cannot be distinguished from noise "
            "({:.3g} {}): there is no motion to compare with",
            measurement.stem.id, unit.factor * std::sqrt(squares / readings), unit.name,
            unit.factor * std::sqrt(noise_squares / readings), unit.name));
}

} // namespace culm::diagnose
