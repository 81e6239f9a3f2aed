// SPDX-License-Identifier: BSD-3-Clause
#include "calibrate/profile_likelihood.hpp"

#include "core/error.hpp"
#include "reduce/distributions.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace culm::calibrate {
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
