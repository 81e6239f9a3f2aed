// SPDX-License-Identifier: BSD-3-Clause
#include "diagnose/held_out.hpp"

#include "core/error.hpp"

#include <cmath>
#include <functional>
#include <limits>

namespace culm::diagnose {
namespace {

constexpr int most_iterations = 10; ///< of a refit

/// Which readings a part consists of.
using IsHeldOut = std::function<bool(std::size_t frame, std::size_t row)>;

HeldOutPart part_of(const fit::ChainPrediction& prediction, const HoldOut& hold_out,
                    const fit::ObservedRecording& recording, const IsHeldOut& is_held_out) {
    HeldOutPart part;
    double squares = 0.0;
    double whitened = 0.0;
    for (std::size_t i = 0; i < prediction.frames; ++i)
        for (std::size_t j = 0; j < prediction.rows; ++j) {
            const double residual =
                recording.deflection(i, j) - prediction.readings[i * prediction.rows + j];
            if (std::isnan(residual) || !is_held_out(i, j))
                continue;
            squares += residual * residual;
            whitened += std::pow(residual / hold_out.noise[j], 2);
            ++part.readings;
        }
    if (part.readings == 0) {
        part.failure = "nothing was measured there";
        return part;
    }
    part.rms = std::sqrt(squares / static_cast<double>(part.readings));
    part.over_noise = std::sqrt(whitened / static_cast<double>(part.readings));
    return part;
}

/// Predicts the held-out readings by a fit to the others.
HeldOutPart predicted_part(const fit::RecordingFit& fit, const HoldOut& hold_out,
                           const fit::ObservedRecording& recording, const IsHeldOut& is_held_out,
                           const fit::FitOptions& options) {
    fit::ObservedRecording seen = recording;
    for (std::size_t i = 0; i < fit.times.size(); ++i)
        for (std::size_t j = 0; j < seen.heights.size(); ++j)
            if (is_held_out(i, j))
                seen.deflections[i * seen.heights.size() + j] =
                    std::numeric_limits<double>::quiet_NaN();
    fit::JointOptions refit;
    refit.chain.window = options.window;
    refit.chain.is_first_guess = false;
    // The refit starts close to its solution. If it drifts along a flat valley, further iterations
    // do not improve the prediction.
    refit.chain.largest_iterations = most_iterations;
    refit.chain.heartbeat = options.heartbeat;
    try {
        const fit::Fit again = fit::fit_jointly({&fit.model, 1}, {&seen, 1}, refit);
        return part_of(
            fit::predict_readings(again.parts.front().model, fit.times, options.heartbeat),
            hold_out, recording, is_held_out);
    } catch (const core::NumericalError& error) {
        HeldOutPart failed;
        failed.failure = error.what();
        return failed;
    }
}

} // namespace

std::size_t row_to_leave_out(const fit::RecordingFit& baseline) {
    std::size_t worst = baseline.prediction.rows - 1;
    double largest = -1.0;
    for (std::size_t j = baseline.prediction.rows / 2; j < baseline.prediction.rows; ++j) {
        double sum = 0.0;
        for (std::size_t i = 0; i < baseline.times.size(); ++i)
            if (const double r = baseline.residuals[i * baseline.prediction.rows + j];
                !std::isnan(r))
                sum += std::pow(r / baseline.noise[j], 2);
        if (sum > largest) {
            largest = sum;
            worst = j;
        }
    }
    return worst;
}

HeldOut predict_held_out(const fit::Fit& candidate, const HoldOut& hold_out,
                         const fit::ObservedRecording& measurement,
                         const fit::FitOptions& options) {
    const fit::RecordingFit& fit = candidate.parts.front();
    const IsHeldOut is_late = [&fit](std::size_t frame, std::size_t) {
        return fit.times[frame] > fit.times.back() * 2.0 / 3.0;
    };
    const IsHeldOut is_in_row = [&hold_out](std::size_t, std::size_t row) {
        return row == hold_out.row;
    };
    if (!candidate.moves())
        return {part_of(fit.prediction, hold_out, measurement, is_late),
                part_of(fit.prediction, hold_out, measurement, is_in_row)};
    HeldOut out{predicted_part(fit, hold_out, measurement, is_late, options), {}};
    if (measurement.heights.size() > 1)
        out.one_height = predicted_part(fit, hold_out, measurement, is_in_row, options);
    else
        out.one_height.failure = "there is only one height";
    return out;
}

} // namespace culm::diagnose
