// SPDX-License-Identifier: BSD-3-Clause
#include "reduce/ring_down/ring_down_fit.hpp"

#include "core/error.hpp"
#include "core/order_statistics.hpp"
#include "reduce/ring_down/ring_down_model.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>

#include <Eigen/Core>
#include <Eigen/QR>
#include <fmt/format.h>

namespace culm::reduce {

namespace {

// Below this share of a period an exponential and a cosine are indistinguishable.
constexpr double fewest_periods = 0.05;
// A free vibration does not grow; noise or beating can imitate growth up to this exponent a cycle.
constexpr double largest_growth_per_cycle = 1.0;
// A frequency is refused if its 95 % interval extends farther than this share of it to either side.
constexpr double widest_frequency_interval = 0.5;
constexpr double adequacy_significance = 0.01;

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

FreeRingDownParameters free_parameters(const RingDownOptions& options) {
    return {options.amplitude_is_free, options.has_phase, options.has_offset};
}

PreparedHistory prepare(std::span<const double> times, std::span<const double> deflections,
                        const RingDownOptions& options) {
    check_input(times, deflections);
    const double tolerance = times.empty() ? 0.0 : 1e-9 * (times.back() - times.front());
    PreparedHistory history;
    std::size_t first = 0;
    for (std::size_t i = 0; i < times.size(); ++i) {
        if (times[i] < -tolerance || (options.window && times[i] > *options.window + tolerance) ||
            (options.is_measured && std::isnan(deflections[i])))
            continue;
        if (!std::isfinite(deflections[i]))
            refuse_history(fmt::format("the deflection at {:g} s is not finite", times[i]));
        if (history.samples.times.empty())
            first = i;
        history.samples.times.push_back(std::max(times[i], 0.0));
        history.samples.values.push_back(deflections[i]);
        history.scale = std::max(history.scale, std::abs(deflections[i]));
    }
    const auto needed = static_cast<std::size_t>(free_parameters(options).count()) + 2;
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

/// Mean over the last tenth of the record, where the motion has decayed most.
double rest_level(const std::vector<double>& values) {
    const std::size_t tail = std::max<std::size_t>(1, values.size() / 10);
    return std::accumulate(values.end() - static_cast<std::ptrdiff_t>(tail), values.end(), 0.0) /
           static_cast<double>(tail);
}

RingDownMinimum best_minimum(const PreparedHistory& history, RingDownProblem& problem,
                             const RingDownOptions& options) {
    const double offset = options.has_offset ? rest_level(history.samples.values) : 0.0;
    RingDownSamples about_rest = history.samples;
    for (double& value : about_rest.values)
        value -= offset;
    const double highest_frequency =
        0.5 / core::median_interval(history.samples.times) * (1.0 + 1e-9);
    std::optional<RingDownMinimum> best;
    for (RingDownParameters start : ring_down_starts(about_rest, options.largest_decay_per_cycle)) {
        start.offset = offset;
        if (!options.amplitude_is_free)
            start.amplitude = history.value_at_release;
        const std::optional<RingDownMinimum> found = minimum_from(problem, start);
        if (found && found->parameters.frequency <= highest_frequency &&
            (!best || found->sum_of_squares < best->sum_of_squares))
            best = found;
    }
    if (!best)
        refuse_history("no frequency up to half the sampling rate explains the history");
    return *best;
}

void check_motion(const RingDownParameters& found, double duration,
                  const RingDownOptions& options) {
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

/// Covariances of the same fit by three assumptions, each (parameters, parameters).
struct FitCovariances {
    Eigen::MatrixXd independent; ///< residuals independent, of one variance
    Eigen::MatrixXd stationary;  ///< residuals correlated the same way everywhere; empty: not asked
    Eigen::MatrixXd newey_west;  ///< any weak correlation and any variance (Newey & West 1987)

    /// Largest variance of the linear combination `direction` of the parameters.
    [[nodiscard]] double variance(const Eigen::VectorXd& direction) const {
        double largest = direction.dot(independent * direction);
        if (stationary.size() > 0)
            largest = std::max({largest, direction.dot(stationary * direction),
                                direction.dot(newey_west * direction)});
        return largest;
    }
};

/// (JᵀJ)⁻¹ by QR of the scaled columns; refuses a Jacobian that is rank deficient.
Eigen::MatrixXd inverse_normal_matrix(const Eigen::MatrixXd& jacobian) {
    const Eigen::Index count = jacobian.cols();
    const Eigen::VectorXd scale = jacobian.colwise().norm();
    const char* reason = "the history does not determine all parameters of Eq. 1";
    if (!(scale.minCoeff() > 0.0))
        refuse_history(reason);
    const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(jacobian *
                                                         scale.cwiseInverse().asDiagonal());
    if (qr.rank() < count)
        refuse_history(reason);
    Eigen::MatrixXd root = Eigen::MatrixXd::Identity(count, count);
    qr.matrixR().topLeftCorner(count, count).triangularView<Eigen::Upper>().solveInPlace(root);
    root = scale.cwiseInverse().asDiagonal() * (qr.colsPermutation() * root);
    return root * root.transpose();
}

/// Correlations are used up to `lags` samples, with Bartlett's weights; 0: none are expected. All
/// are scaled by n/(n − parameters).
FitCovariances fit_covariances(const RingDownProblem& problem, std::size_t lags) {
    const Eigen::MatrixXd& jacobian = problem.jacobian();
    const Eigen::VectorXd& residuals = problem.residuals();
    const auto n = static_cast<double>(jacobian.rows());
    const double freedom = n - static_cast<double>(jacobian.cols());
    const Eigen::MatrixXd bread = inverse_normal_matrix(jacobian);
    FitCovariances covariances{problem.sum_of_squares() / freedom * bread, {}, {}};
    if (lags == 0)
        return covariances;
    // The sandwich (JᵀJ)⁻¹ M (JᵀJ)⁻¹ with M the covariance of Jᵀe.
    std::vector<double> covariance = autocovariance(
        std::span(residuals.data(), static_cast<std::size_t>(residuals.size())), lags);
    const std::vector<double> weights = bartlett_weights(lags);
    for (std::size_t lag = 0; lag < covariance.size(); ++lag)
        covariance[lag] *= weights[lag];
    const Eigen::MatrixXd scores = jacobian.array().colwise() * residuals.array();
    covariances.stationary = n / freedom * (bread * lagged_sum(jacobian, covariance) * bread);
    covariances.newey_west = n / freedom * (bread * lagged_sum(scores, weights) * bread);
    return covariances;
}

/// Lags of the correlation: one period, but at most a fifth of the record.
std::size_t lags_of(const RingDownSamples& samples, double frequency) {
    const double period = 1.0 / (frequency * core::median_interval(samples.times));
    const auto n = static_cast<double>(samples.times.size());
    const double automatic = 4.0 * std::pow(n / 100.0, 2.0 / 9.0); // Newey & West (1994)
    return static_cast<std::size_t>(
        std::clamp(std::ceil(std::max(period, automatic)), 1.0, std::max(1.0, n / 5.0)));
}

/// Values with intervals by the covariances of the free parameters, to first order.
void set_estimates(const RingDownParameters& at, const FreeRingDownParameters& free,
                   const FitCovariances& covariances, double scale, RingDownFit& fit) {
    const double factor = student_t_factor(fit.samples - static_cast<std::size_t>(free.count()));
    const auto estimated = [&](double value, double unit, const Eigen::VectorXd& direction) {
        return estimate(unit * value, unit * unit * covariances.variance(direction), factor);
    };
    const Eigen::Index b1 = free.decay();
    const Eigen::VectorXd none = Eigen::VectorXd::Zero(free.count());
    const auto along = [&](Eigen::Index index) {
        return Eigen::VectorXd::Unit(none.size(), index);
    };
    fit.decay_rate = estimated(at.decay_rate, 1.0, along(b1));
    fit.frequency = estimated(at.frequency, 1.0, along(b1 + 1));
    Eigen::VectorXd ratio = none; // gradient of b1/b2
    ratio[b1] = 1.0 / at.frequency;
    ratio[b1 + 1] = -at.decay_rate / (at.frequency * at.frequency);
    fit.decay_per_cycle = estimated(at.decay_rate / at.frequency, 1.0, ratio);
    fit.independent_decay_error = std::sqrt(ratio.dot(covariances.independent * ratio));
    const double amplitude = std::copysign(std::hypot(at.amplitude, at.quadrature), at.amplitude);
    Eigen::VectorXd of_amplitude = none;
    Eigen::VectorXd of_phase = none;
    if (free.amplitude)
        of_amplitude[0] = at.amplitude / amplitude;
    if (free.quadrature) {
        of_amplitude[b1 + 2] = at.quadrature / amplitude;
        of_phase[0] = -at.quadrature / (amplitude * amplitude);
        of_phase[b1 + 2] = at.amplitude / (amplitude * amplitude);
        fit.phase = estimated(std::atan(at.quadrature / at.amplitude), 1.0, of_phase);
    }
    fit.amplitude = estimated(amplitude, scale, of_amplitude);
    if (free.offset)
        fit.offset = estimated(at.offset, scale, along(free.count() - 1));
}

double sum_of_squares_about_mean(const std::vector<double>& values) {
    const double mean =
        std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
    double sum = 0.0;
    for (const double value : values)
        sum += (value - mean) * (value - mean);
    return sum;
}

/// Tests whether the residuals are larger than the noise (χ²), correlated (Ljung & Box 1978), or of
/// one sign for too long (runs; Wald & Wolfowitz 1940).
RingDownAdequacy adequacy_of(const std::vector<double>& residuals, std::size_t lags,
                             std::size_t parameters, const std::optional<double>& noise) {
    RingDownAdequacy adequacy;
    adequacy.ljung_box_p_value = ljung_box_p_value(residuals, lags);
    adequacy.runs_p_value = runs_p_value(residuals);
    std::vector<std::string> reasons;
    if (noise && residuals.size() > parameters) {
        double sum = 0.0;
        for (const double residual : residuals)
            sum += residual * residual;
        const double freedom = static_cast<double>(residuals.size() - parameters);
        sum /= *noise * *noise;
        adequacy.reduced_chi_squared = sum / freedom;
        adequacy.chi_squared_p_value = chi_squared_p_value(sum, freedom);
        if (*adequacy.chi_squared_p_value < adequacy_significance)
            reasons.push_back(
                fmt::format("residuals {:.2g} x noise", std::sqrt(*adequacy.reduced_chi_squared)));
    }
    if (std::min(adequacy.ljung_box_p_value, adequacy.runs_p_value) < adequacy_significance)
        reasons.emplace_back("correlated");
    adequacy.is_adequate = reasons.empty();
    for (const std::string& reason : reasons)
        adequacy.reason += (adequacy.reason.empty() ? "" : ", ") + reason;
    return adequacy;
}

} // namespace

RingDownFit fit_ring_down(std::span<const double> times, std::span<const double> deflections,
                          const RingDownOptions& options) {
    const PreparedHistory history = prepare(times, deflections, options);
    const RingDownSamples& samples = history.samples;
    const FreeRingDownParameters free = free_parameters(options);
    RingDownProblem problem(samples, free);
    const RingDownMinimum best = best_minimum(history, problem, options);
    check_motion(best.parameters, samples.times.back(), options);
    problem.evaluate(best.parameters);
    problem.evaluate_jacobian();
    const std::size_t lags = lags_of(samples, best.parameters.frequency);
    const FitCovariances covariances = fit_covariances(problem, options.is_measured ? lags : 0);

    RingDownFit fit;
    fit.samples = samples.times.size();
    fit.largest_deflection = history.scale;
    set_estimates(best.parameters, free, covariances, history.scale, fit);
    const auto n = static_cast<double>(fit.samples);
    fit.rms_residual = history.scale * std::sqrt(best.sum_of_squares / n);
    // R² = 1 − SS_residual/SS_about_mean; Eq. 1 has no constant, so that it can be negative.
    fit.r_squared = 1.0 - best.sum_of_squares / sum_of_squares_about_mean(samples.values);
    const Eigen::Index b2 = free.decay() + 1;
    const double error = std::sqrt(covariances.independent(b2, b2));
    const double reach =
        error * student_t_factor(fit.samples - static_cast<std::size_t>(free.count()));
    if (!(reach <= widest_frequency_interval * fit.frequency.value))
        refuse_history(
            fmt::format("the history is too short or too noisy to determine the frequency: "
                        "{:.4g} Hz with a standard error of {:.2g} Hz from {} samples",
                        fit.frequency.value, error, fit.samples));
    if (!options.is_measured)
        return fit;
    for (const double residual : problem.residuals())
        fit.residuals.push_back(-history.scale * residual);
    fit.adequacy =
        adequacy_of(fit.residuals, lags, static_cast<std::size_t>(free.count()), options.noise);
    return fit;
}

} // namespace culm::reduce
