// SPDX-License-Identifier: BSD-3-Clause
#include "diagnose/verdict.hpp"

#include "fit/solve/residual_statistics.hpp"
#include "reduce/population_statistics.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/core.h>

namespace culm::diagnose {
namespace {

constexpr double smallest_p_value = 0.01;
constexpr double fewest_cycles = 2.0;
constexpr double smallest_swing = 3.0; ///< over its noise, root mean square
constexpr std::size_t fewest_frames = 30;

/// Why the record cannot tell; empty if it can.
std::string what_is_too_little(const fit::RecordingFit& fit, const Swing& swing) {
    double squares = 0.0;
    std::size_t frames = 0;
    for (std::size_t i = 0; i < swing.times.size(); ++i)
        if (swing.times[i] >= 0.0 && !std::isnan(swing.measured[i])) {
            squares += swing.measured[i] * swing.measured[i];
            ++frames;
        }
    if (frames < fewest_frames)
        return fmt::format("{} frames after the release are too few to tell; {} are needed", frames,
                           fewest_frames);
    if (const double cycles = fit.times.back() * swing.frequency; cycles < fewest_cycles)
        return fmt::format("{:.1f} cycles after the release are too few to tell; {} are needed",
                           cycles, fewest_cycles);
    const double size = std::sqrt(squares / static_cast<double>(frames));
    if (fit.is_noise_known && size < smallest_swing * swing.noise)
        return fmt::format("the motion (rms {:.3g} mm) hardly stands out of the noise ({:.3g} mm "
                           "with all heights together)",
                           1e3 * size, 1e3 * swing.noise);
    return {};
}

std::size_t lags_over_a_period(const fit::RecordingFit& fit, const Swing& swing) {
    const std::size_t frames = fit.times.size();
    if (frames < 10)
        return 1;
    const double interval =
        (fit.times.back() - fit.times.front()) / static_cast<double>(frames - 1);
    const auto lags = static_cast<std::size_t>(std::lround(1.0 / (swing.frequency * interval)));
    return std::clamp<std::size_t>(lags, 2, frames / 5);
}

void adjust(Verdict& verdict) {
    std::vector<double> p_values;
    for (const calibrate::LackOfFitTest& test : verdict.tests)
        p_values.push_back(test.p_value);
    const std::vector<double> adjusted = reduce::holm_adjusted(p_values);
    verdict.finding = Finding::Adequate;
    for (std::size_t k = 0; k < adjusted.size(); ++k) {
        verdict.tests[k].adjusted_p_value = adjusted[k];
        verdict.p_value = std::min(verdict.p_value, adjusted[k]);
        if (adjusted[k] >= smallest_p_value)
            continue;
        verdict.finding = Finding::Inadequate;
        verdict.reason += (verdict.reason.empty() ? "" : ", ") + verdict.tests[k].name;
    }
}

} // namespace

std::string_view to_string(Finding finding) {
    switch (finding) {
    case Finding::Adequate:
        return "adequate";
    case Finding::Inadequate:
        return "inadequate";
    case Finding::Undecided:
        return "undecided";
    }
    return "undecided";
}

Verdict judge(const fit::RecordingFit& fit, const Swing& swing) {
    Verdict verdict;
    verdict.rmse = fit.rmse;
    verdict.noise = typical_noise(fit);
    verdict.is_noise_known = fit.is_noise_known;
    verdict.reduced_chi_squared = fit.reduced_chi_squared;
    const Eigen::MatrixXd whitened = fit::whitened_residuals(fit);
    verdict.effective_degrees_of_freedom =
        std::min(fit::effective_degrees_of_freedom(whitened, lags_over_a_period(fit, swing)),
                 static_cast<double>(std::max<std::size_t>(fit.degrees_of_freedom, 1)));
    verdict.tests = calibrate::test_lack_of_fit(fit).tests;
    for (calibrate::LackOfFitTest& test : verdict.tests)
        if (test.name == "size")
            test.p_value = fit::chi_squared_tail(verdict.effective_degrees_of_freedom *
                                                     fit.reduced_chi_squared,
                                                 verdict.effective_degrees_of_freedom);
    const fit::SpatialPattern pattern = fit::spatial_pattern(whitened);
    verdict.tests.push_back({"pattern over the heights", pattern.p_value, pattern.p_value});
    verdict.spatial_share = pattern.share;
    const double size = std::sqrt(pattern.share * whitened.squaredNorm() /
                                  static_cast<double>(std::max<Eigen::Index>(whitened.rows(), 1)));
    for (Eigen::Index j = 0; j < pattern.shape.size(); ++j)
        verdict.spatial_pattern.push_back(size * pattern.shape(j) *
                                          fit.noise[static_cast<std::size_t>(j)]);
    adjust(verdict);
    if (std::string reason = what_is_too_little(fit, swing); !reason.empty()) {
        verdict.finding = Finding::Undecided;
        verdict.reason = std::move(reason);
    }
    return verdict;
}

} // namespace culm::diagnose
