// SPDX-License-Identifier: BSD-3-Clause
#include "reduce/ring_down/ring_down_fit.hpp"

#include "core/error.hpp"
#include "core/order_statistics.hpp"
#include "reduce/distributions.hpp"
#include "reduce/ring_down/ring_down_model.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>

#include <fmt/format.h>

namespace culm::reduce {

namespace {

// Below this share of a period an exponential and a cosine are indistinguishable.
constexpr double fewest_periods = 0.05;
// A free vibration does not grow; noise or beating can imitate growth up to this exponent a cycle.
constexpr double largest_growth_per_cycle = 1.0;
// A frequency is refused if its 95 % interval extends farther than this share of it to either side.
constexpr double widest_frequency_interval = 0.5;

[[noreturn]] void refuse_history(const std::string& sentence) {
    throw core::NumericalError(core::FailureKind::FitFailed, sentence);
}

/// Normalised samples from the release on, and the scale that they were divided by.
struct PreparedHistory {
    RingDownSamples samples;
    double scale = 0.0;            // m
    double value_at_release = 0.0; // normalised; set only if the amplitude is fixed
};

/// The deflection at t = 0: a sample, or interpolated between the last one before and the first one
/// after the release. `first` is the first sample used.
double deflection_at_release(std::span<const double> times, std::span<const double> deflections,
                             std::size_t first, double tolerance) {
    if (times[first] <= tolerance)
        return deflections[first];
    if (first == 0 || !std::isfinite(deflections[first - 1]))
        refuse_history(
            fmt::format("the amplitude is fixed to the deflection at the release, but the first "
                        "sample is {:g} s after it",
                        times[first]));
    const double fraction = -times[first - 1] / (times[first] - times[first - 1]);
    return std::lerp(deflections[first - 1], deflections[first], fraction);
}

void check_input(std::span<const double> times, std::span<const double> deflections) {
    if (times.size() != deflections.size())
        refuse_history(fmt::format("the history has {} times but {} deflections", times.size(),
                                   deflections.size()));
    for (std::size_t i = 0; i < times.size(); ++i) {
        if (!std::isfinite(times[i]))
            refuse_history(fmt::format("time {} of the history is not finite", i));
        if (i > 0 && times[i] <= times[i - 1])
            refuse_history(fmt::format("time {} of the history, {:g} s, does not follow {:g} s", i,
                                       times[i], times[i - 1]));
    }
}

PreparedHistory prepare(std::span<const double> times, std::span<const double> deflections,
                        const RingDownFitOptions& options) {
    check_input(times, deflections);
    const double tolerance = times.empty() ? 0.0 : 1e-9 * (times.back() - times.front());
    PreparedHistory history;
    std::size_t first = 0;
    for (std::size_t i = 0; i < times.size(); ++i) {
        if (times[i] < -tolerance || (options.window && times[i] > *options.window + tolerance))
            continue;
        if (!std::isfinite(deflections[i]))
            refuse_history(fmt::format("the deflection at {:g} s is not finite", times[i]));
        if (history.samples.times.empty())
            first = i;
        history.samples.times.push_back(std::max(times[i], 0.0));
        history.samples.values.push_back(deflections[i]);
        history.scale = std::max(history.scale, std::abs(deflections[i]));
    }
    const std::size_t needed = options.amplitude_is_free ? 5 : 4;
    if (history.samples.times.size() < needed)
        refuse_history(
            fmt::format("Eq. 1 needs at least {} samples after the release, the history has {}",
                        needed, history.samples.times.size()));
    const auto [lowest, highest] = std::ranges::minmax(history.samples.values);
    if (highest - lowest <= 1e-12 * history.scale)
        refuse_history(
            fmt::format("the deflection is constant at {:g} m: nothing vibrates", highest));
    if (!options.amplitude_is_free)
        history.value_at_release =
            deflection_at_release(times, deflections, first, tolerance) / history.scale;
    // With amplitudes of order 1 the tolerances of the fit do not depend on the unit.
    for (double& value : history.samples.values)
        value /= history.scale;
    return history;
}

RefinedRingDown best_minimum(const PreparedHistory& history, const RingDownFitOptions& options) {
    // The sum of squares has a minimum near every frequency of the history, so each start is
    // refined. Frequencies from half the sampling rate on have a lower alias with the same samples.
    const double highest_frequency =
        0.5 / core::median_interval(history.samples.times) * (1.0 + 1e-9);
    std::optional<RefinedRingDown> best;
    for (RingDownParameters start :
         ring_down_starts(history.samples, options.largest_decay_per_cycle)) {
        if (!options.amplitude_is_free)
            start.amplitude = history.value_at_release;
        const std::optional<RefinedRingDown> refined =
            refine_ring_down(history.samples, start, options.amplitude_is_free);
        if (!refined || refined->parameters.frequency > highest_frequency)
            continue;
        if (!best || refined->residual_sum_of_squares < best->residual_sum_of_squares)
            best = refined;
    }
    if (!best)
        refuse_history("no frequency up to half the sampling rate explains the history");
    return *best;
}

void check_motion(const RingDownParameters& found, double duration,
                  const RingDownFitOptions& options) {
    const double periods = found.frequency * duration;
    if (!(periods >= fewest_periods))
        refuse_history(
            fmt::format("the history does not vibrate: its best fit makes {:.2g} periods in {:g} s",
                        periods, duration));
    const double decay = -found.decay_rate / found.frequency;
    if (!(decay >= -largest_growth_per_cycle))
        refuse_history(
            fmt::format("the motion is not a ring-down: its best fit, {:.4g} Hz, grows by "
                        "exp({:.3g}) per cycle",
                        found.frequency, -decay));
    if (!(decay <= options.largest_decay_per_cycle))
        refuse_history(
            fmt::format("the motion is near-critically damped: its best fit, {:.4g} Hz, decays by "
                        "exp(-{:.3g}) per cycle (largest allowed exponent {:.3g})",
                        found.frequency, decay, options.largest_decay_per_cycle));
}

void set_uncertainties(const Eigen::Matrix3d& covariance, double factor, RingDownFit& fit) {
    fit.amplitude_uncertainty = estimate(fit.amplitude, covariance(0, 0), factor);
    fit.decay_rate_uncertainty = estimate(fit.decay_rate, covariance(1, 1), factor);
    fit.frequency_uncertainty = estimate(fit.frequency, covariance(2, 2), factor);
    // Propagated to first order through b1/b2, with the covariance of both.
    const Eigen::Vector3d gradient(0.0, 1.0 / fit.frequency, -fit.decay_per_cycle / fit.frequency);
    fit.decay_per_cycle_uncertainty =
        estimate(fit.decay_per_cycle, gradient.dot(covariance * gradient), factor);
}

double sum_of_squares_about_mean(const std::vector<double>& values) {
    const double mean =
        std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
    double sum = 0.0;
    for (const double value : values)
        sum += (value - mean) * (value - mean);
    return sum;
}

} // namespace

RingDownFit fit_ring_down(std::span<const double> times, std::span<const double> deflections,
                          const RingDownFitOptions& options) {
    const PreparedHistory history = prepare(times, deflections, options);
    RefinedRingDown best = best_minimum(history, options);
    check_motion(best.parameters, history.samples.times.back(), options);
    if (!polish_ring_down(history.samples, options.amplitude_is_free, best))
        refuse_history(
            "the fit of Eq. 1 does not converge: the history does not determine its parameters");
    check_motion(best.parameters, history.samples.times.back(), options);
    const std::optional<Eigen::Matrix3d> covariance =
        ring_down_covariance(history.samples, options.amplitude_is_free, best);
    if (!covariance)
        refuse_history("the history does not determine all parameters of Eq. 1");

    const std::size_t samples = history.samples.times.size();
    RingDownFit fit;
    fit.amplitude = best.parameters.amplitude;
    fit.decay_rate = best.parameters.decay_rate;
    fit.frequency = best.parameters.frequency;
    fit.decay_per_cycle = fit.decay_rate / fit.frequency;
    fit.deflection_scale = history.scale;
    fit.rms_residual = std::sqrt(best.residual_sum_of_squares / static_cast<double>(samples));
    // R² = 1 − SS_residual/SS_about_mean; Eq. 1 has no constant, so that it can be negative.
    fit.r_squared =
        1.0 - best.residual_sum_of_squares / sum_of_squares_about_mean(history.samples.values);
    fit.iterations = best.iterations;
    fit.samples = samples;
    const std::size_t free_parameters = options.amplitude_is_free ? 3 : 2;
    set_uncertainties(*covariance, student_t_factor(samples - free_parameters), fit);
    const double reach = fit.frequency - fit.frequency_uncertainty.lower;
    if (!(reach <= widest_frequency_interval * fit.frequency))
        refuse_history(
            fmt::format("the history is too short or too noisy to determine the frequency: "
                        "{:.4g} Hz with a standard error of {:.2g} Hz from {} samples",
                        fit.frequency, fit.frequency_uncertainty.standard_error, samples));
    return fit;
}

} // namespace culm::reduce
