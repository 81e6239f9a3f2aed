// SPDX-License-Identifier: BSD-3-Clause
#include "calibrate/calibration.hpp"

#include "core/error.hpp"
#include "fit/solve/reading_errors.hpp"
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

/// Eq. 1 needs an offset for a stem released straight: its rest position is not zero.
reduce::RingDownAnalysisOptions check_options(const measure::Measurement& measurement,
                                              const CalibrationOptions& options) {
    reduce::RingDownAnalysisOptions check;
    check.window = options.fit.window;
    check.has_offset = measurement.release == measure::ReleaseKind::HeldStraight;
    check.has_phase = measurement.release == measure::ReleaseKind::Moving;
    return check;
}

/// The last model of fit_nested(), and the recording that it was fitted to.
struct FittedStem {
    fit::ModelFit model;
    fit::ObservedRecording recording; ///< with inputs as stated
};

FittedStem fitted(const measure::Measurement& measurement, const CalibrationOptions& options) {
    refuse_motionless(measurement, options.effects);
    std::vector<fit::SelectedEffects> sets;
    if (!options.effects.empty())
        sets.push_back(options.effects);
    fit::NestedFits fits = fit::fit_nested({&measurement, 1}, sets, options.fit);
    fit::ModelFit& model = fits.models.back();
    // A parameter at its bound is not calibrated, unless only the error terms move it there.
    const std::string& reason = model.stated.reason.empty() && model.judged.failed()
                                    ? model.judged.reason
                                    : model.stated.reason;
    if (!reason.empty())
        throw core::NumericalError(core::FailureKind::FitFailed,
                                   fmt::format("{}: {}", measurement.stem.id, reason));
    return {std::move(model), fit::with_inputs_as_stated(fits.recordings).front()};
}

fit::SolveOptions solve_options(const fit::FitOptions& options) {
    fit::SolveOptions solve;
    solve.window = options.window;
    solve.heartbeat = options.heartbeat;
    return solve;
}

} // namespace

Calibration calibrate_stem(const measure::Measurement& measurement,
                           const CalibrationOptions& options) {
    Calibration result;
    result.id = measurement.stem.id;
    FittedStem stem = fitted(measurement, options);
    result.fit = std::move(stem.model.stated.parts.front());
    result.judged = std::move(stem.model.judged.parts.front());
    result.budget = fit::uncertainty_budget(result.fit, result.judged, measurement);
    const run::CaseSpec chain = fit::case_beside_errors(result.fit.model);
    result.mode = run::first_mode(chain);
    result.damping_time = fit::damping_time(chain);
    result.verdict =
        diagnose::verdict_on(result.judged, residuals::swing_of(result.judged, measurement));
    if (options.with_profiles)
        result.profiles =
            profile_intervals(result.fit, stem.recording, result.judged.reduced_chi_squared,
                              solve_options(options.fit));
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
    constexpr std::uint64_t seed = 2019; // arbitrary
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
    Profile(const fit::RecordingFit& fit, const fit::ObservedRecording& measurement, double misfit,
            const fit::SolveOptions& options)
        : fit_(fit), measurement_(measurement), options_(options),
          unit_(std::sqrt(std::max(1.0, misfit))) {}

    /// The end of the interval on one side (±1) of the fitted value, with the inputs' contribution.
    double end_with_inputs(std::size_t parameter, double side) {
        const double value = fit_.parameters[parameter].value;
        return value + side * std::hypot(end(parameter, side) - value,
                                         reduce::normal_quantile_95 * of_inputs(parameter));
    }

    [[nodiscard]] int runs() const { return runs_; }

  private:
    /// Standard uncertainties that the readings and the inputs contribute.
    [[nodiscard]] double of_inputs(std::size_t parameter) const {
        return fit_.input_changes.size() == 0
                   ? 0.0
                   : fit_.input_changes.row(static_cast<Eigen::Index>(parameter)).norm();
    }
    [[nodiscard]] double of_readings(std::size_t parameter) const {
        const double all = fit_.parameters[parameter].standard_error;
        return std::sqrt(std::max(0.0, all * all - std::pow(of_inputs(parameter), 2)));
    }

    double end(std::size_t parameter, double side) {
        const fit::FittedParameter& fitted = fit_.parameters[parameter];
        const double limit = side > 0.0 ? fitted.upper : fitted.lower;
        double distance = reduce::normal_quantile_95 * of_readings(parameter);
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
            // A flat profile is searched in steps of twice the distance.
            const double next = distance + (reduce::normal_quantile_95 - root) / slope;
            distance =
                slope > 0.0 ? std::clamp(next, 0.3 * distance, 2.0 * distance) : 2.0 * distance;
        }
        return std::numeric_limits<double>::quiet_NaN();
    }

    /// √(excess of χ²) in the units of the fit.
    double root_at(std::size_t parameter, double value) {
        std::vector<bool> is_held(fit_.parameters.size(), false);
        is_held[parameter] = true;
        const fit::RecordingFit held = fit_chain_with_held(with_value(fit_.model, parameter, value),
                                                           measurement_, is_held, options_);
        runs_ += held.runs;
        // With an unknown noise each fit scales its own, so only the ratio of the sums is usable.
        const double excess = fit_.is_noise_known
                                  ? held.chi_squared - fit_.chi_squared
                                  : static_cast<double>(fit_.degrees_of_freedom) *
                                        (held.rmse * held.rmse / (fit_.rmse * fit_.rmse) - 1.0);
        return std::sqrt(std::max(0.0, excess)) / unit_;
    }

    const fit::RecordingFit& fit_;
    const fit::ObservedRecording& measurement_;
    const fit::SolveOptions& options_;
    double unit_;
    int runs_ = 0;
};

} // namespace

std::vector<ProfileInterval> profile_intervals(const fit::RecordingFit& fit,
                                               const fit::ObservedRecording& measurement,
                                               double misfit, const fit::SolveOptions& options) {
    std::vector<ProfileInterval> intervals;
    for (std::size_t k = 0; k < fit.model.first_error(); ++k) {
        Profile profile(fit, measurement, misfit, options);
        const double lower = profile.end_with_inputs(k, -1.0);
        const double upper = profile.end_with_inputs(k, 1.0);
        intervals.push_back({to_string(fit.parameters[k].id), lower, upper, profile.runs()});
    }
    return intervals;
}

} // namespace culm::calibrate
