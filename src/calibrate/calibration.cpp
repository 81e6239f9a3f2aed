// SPDX-License-Identifier: BSD-3-Clause
#include "calibrate/calibration.hpp"

#include "core/error.hpp"
#include "fit/model/stem_model.hpp"
#include "reduce/distributions.hpp"
#include "run/modes.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <vector>

#include <fmt/core.h>

namespace culm::calibrate {
namespace {

void refuse_motionless(const measure::Measurement& measurement,
                       const std::vector<physics::SelectedEffect>& effects) {
    if (measurement.release == measure::ReleaseKind::HeldStraight && effects.empty())
        throw core::InputError(
            fmt::format("{}: [release] kind = \"held_straight\": nothing moves such a stem in a "
                        "model without gravity; add --with gravity",
                        measurement.stem.id));
}

/// A stem that is let go gets its rest position from what moves it, so Eq. 1 needs an offset.
reduce::RingDownAnalysisOptions check_options(const measure::Measurement& measurement,
                                              const CalibrationOptions& options) {
    reduce::RingDownAnalysisOptions check;
    check.window = options.fit.window;
    check.has_offset = measurement.release == measure::ReleaseKind::HeldStraight;
    check.has_phase = measurement.release == measure::ReleaseKind::Moving;
    return check;
}

} // namespace

fit::StemModel model_with_effects(const measure::Measurement& measurement,
                                  const CalibrationOptions& options) {
    refuse_motionless(measurement, options.effects);
    fit::StemModel model = baseline_model(measurement, options.chain);
    for (const physics::SelectedEffect& effect : options.effects)
        model = with_effect(std::move(model), effect, measurement);
    return model;
}

Calibration calibrate_stem(const measure::Measurement& measurement,
                           const CalibrationOptions& options) {
    Calibration result;
    result.id = measurement.stem.id;
    result.fit = fit::fit_chain_beside_errors(model_with_effects(measurement, options), measurement,
                                              options.fit);
    if (!result.fit.reason.empty())
        throw core::NumericalError(core::FailureKind::FitFailed,
                                   fmt::format("{}: {}", result.id, result.fit.reason));
    result.budget = fit::uncertainty_budget(result.fit, measurement);
    const run::CaseSpec chain = fit::case_beside_errors(result.fit.model);
    result.mode = run::first_mode(chain);
    result.damping_time = fit::damping_time(chain);
    result.verdict = diagnose::verdict_on(result.fit, residuals::swing_of(result.fit, measurement));
    if (options.with_profiles)
        result.profiles = profile_intervals(result.fit, measurement, options.fit);
    if (options.with_check) {
        try {
            result.check =
                check_calibration(result.fit, measurement, check_options(measurement, options),
                                  options.check_integrator);
        } catch (const core::NumericalError& error) {
            result.check_failure = error.what();
        }
    }
    return result;
}

namespace {

/// A whole number below `count`, the same on every standard library (a bias of count/2⁶⁴).
std::size_t draw_below(std::mt19937_64& generator, std::size_t count) {
    __extension__ using Wide = unsigned __int128;
    return static_cast<std::size_t>((static_cast<Wide>(generator()) * count) >> 64U);
}

reduce::Bounds central_95_percent(std::vector<double> values) {
    std::ranges::sort(values);
    return {reduce::quantile(values, 0.025), reduce::quantile(values, 0.975)};
}

} // namespace

CentralRange central_range(std::span<const double> values, int resamples) {
    CentralRange result;
    result.sample = reduce::summarise(values);
    result.range = result.sample.central_90_percent;
    result.lower_interval = result.upper_interval = result.range;
    if (values.size() < 2)
        return result;
    constexpr std::uint64_t seed = 2019; // any would do
    std::mt19937_64 generator(seed);
    std::vector<double> lower;
    std::vector<double> upper;
    std::vector<double> drawn(values.size());
    for (int k = 0; k < resamples; ++k) {
        for (double& value : drawn)
            value = values[draw_below(generator, values.size())];
        std::ranges::sort(drawn);
        lower.push_back(reduce::quantile(drawn, 0.05));
        upper.push_back(reduce::quantile(drawn, 0.95));
    }
    result.lower_interval = central_95_percent(std::move(lower));
    result.upper_interval = central_95_percent(std::move(upper));
    return result;
}

namespace {

constexpr int most_secants = 6;
constexpr double accuracy = 0.02;

fit::StemModel with_value(fit::StemModel model, std::size_t parameter, double value) {
    model.set_value(parameter, value);
    return model;
}

class Profile {
  public:
    Profile(const fit::RecordingFit& fit, const measure::Measurement& measurement,
            const fit::SolveOptions& options)
        : fit_(fit), measurement_(measurement), options_(options),
          unit_(std::sqrt(std::max(1.0, fit.reduced_chi_squared))) {}

    /// The end of the interval on one side (±1) of the fitted value.
    double end(std::size_t parameter, double side) {
        const fit::FittedParameter& fitted = fit_.parameters[parameter];
        const double limit = side > 0.0 ? fitted.upper : fitted.lower;
        double distance = reduce::normal_quantile_95 * fitted.standard_error;
        if (!(distance > 0.0) || !std::isfinite(distance))
            return std::numeric_limits<double>::quiet_NaN();
        double known_distance = 0.0;
        double known_root = 0.0;
        for (int k = 0; k < most_secants; ++k) {
            distance = std::min(distance, std::abs(limit - fitted.value));
            const double root = root_at(parameter, fitted.value + side * distance);
            if (std::abs(root - reduce::normal_quantile_95) < accuracy * reduce::normal_quantile_95)
                return fitted.value + side * distance;
            if (root < reduce::normal_quantile_95 && distance >= std::abs(limit - fitted.value))
                break;
            // The root of the excess is linear where the likelihood is a parabola, so the secant
            // method needs few fits.
            const double slope = (root - known_root) / (distance - known_distance);
            known_distance = distance;
            known_root = root;
            // A profile that has gone flat is left in steps of twice the distance.
            const double next = distance + (reduce::normal_quantile_95 - root) / slope;
            distance =
                slope > 0.0 ? std::clamp(next, 0.3 * distance, 2.0 * distance) : 2.0 * distance;
        }
        return std::numeric_limits<double>::quiet_NaN();
    }

    [[nodiscard]] int runs() const { return runs_; }

  private:
    /// √(excess of χ²) in the units of the fit.
    double root_at(std::size_t parameter, double value) {
        std::vector<bool> is_held(fit_.parameters.size(), false);
        is_held[parameter] = true;
        const fit::RecordingFit held = fit_chain_with_held(with_value(fit_.model, parameter, value),
                                                           measurement_, is_held, options_);
        runs_ += held.runs;
        // Without a known noise each fit scales its own; the ratio of the sums is what is left.
        const double excess = fit_.is_noise_known
                                  ? held.chi_squared - fit_.chi_squared
                                  : static_cast<double>(fit_.degrees_of_freedom) *
                                        (held.rmse * held.rmse / (fit_.rmse * fit_.rmse) - 1.0);
        return std::sqrt(std::max(0.0, excess)) / unit_;
    }

    const fit::RecordingFit& fit_;
    const measure::Measurement& measurement_;
    const fit::SolveOptions& options_;
    double unit_;
    int runs_ = 0;
};

} // namespace

std::vector<ProfileInterval> profile_intervals(const fit::RecordingFit& fit,
                                               const measure::Measurement& measurement,
                                               const fit::SolveOptions& options) {
    // Huber's loss is no likelihood: its excess has no known distribution.
    fit::SolveOptions plain = options;
    plain.is_robust = false;
    std::vector<ProfileInterval> intervals;
    for (std::size_t k = 0; k < fit.model.first_error(); ++k) {
        Profile profile(fit, measurement, plain);
        const double lower = profile.end(k, -1.0);
        const double upper = profile.end(k, 1.0);
        intervals.push_back({to_string(fit.parameters[k].id), lower, upper, profile.runs()});
    }
    return intervals;
}

} // namespace culm::calibrate
