// SPDX-License-Identifier: BSD-3-Clause
#include "calibrate/calibration.hpp"

#include "core/error.hpp"
#include "diagnose/ladder.hpp"
#include "residuals/swing.hpp"
#include "run/modes.hpp"

#include <cmath>
#include <vector>

#include <fmt/core.h>

namespace culm::calibrate {
namespace {

/// Readings of the model at all measured heights and times.
reduce::StemHistories simulated_histories(fit::StemModel model,
                                          const measure::Measurement& measurement,
                                          run::IntegrationMethod method) {
    // The fit is finished: without derivatives any integrator may be used.
    model.parameters.clear();
    model.release_time_bound = 0.0;
    model.spec.integrator.method = method;
    reduce::StemHistories stem = residuals::histories_of(measurement);
    const fit::ChainPrediction prediction = predict_readings(model, measurement.times);
    for (std::size_t j = 0; j < stem.heights.size(); ++j)
        for (std::size_t i = 0; i < stem.times.size(); ++i)
            if (!std::isnan(stem.histories[j][i]))
                stem.histories[j][i] = prediction.readings[i * prediction.rows + j];
    return stem;
}

PairedMean paired_mean(const CalibrationCheck& check,
                       reduce::Estimate reduce::RingDownFit::*quantity) {
    double weights = 0.0;
    double measured_sum = 0.0;
    double simulated_sum = 0.0;
    for (std::size_t j = 0; j < check.measured.heights.size(); ++j) {
        const auto& measured = check.measured.heights[j].fit;
        const auto& simulated = check.simulated.heights[j].fit;
        if (!measured || !simulated)
            continue;
        // Both means use the weights of the measurement: a height where it is uncertain must not
        // change the simulated mean alone.
        const double error = (*measured.*quantity).standard_error;
        const double weight = 1.0 / (error * error);
        weights += weight;
        measured_sum += weight * (*measured.*quantity).value;
        simulated_sum += weight * (*simulated.*quantity).value;
    }
    return {measured_sum / weights, simulated_sum / weights, 1.0 / std::sqrt(weights)};
}

/// Eq. 1 needs an offset for a stem released straight: its rest position is not zero.
reduce::RingDownOptions check_options(const measure::Measurement& measurement,
                                      const CalibrationOptions& options) {
    reduce::RingDownOptions check;
    check.window = options.fit.window;
    check.has_offset = measurement.release == measure::ReleaseKind::HeldStraight;
    check.has_phase = measurement.release == measure::ReleaseKind::Moving;
    return check;
}

/// A fit may end in a valley whose first mode is not the swing: all later numbers are then wrong.
void require_swing(const measure::Measurement& measurement, const fit::RecordingFit& fit,
                   const CalibrationOptions& options) {
    constexpr double largest_ratio = 1.25; // Eq. 1 of a swing with an effect is right within that
    const fit::StemModel started = fit::baseline_model(measurement, options.fit.chain);
    const double swing = run::lightly_damped_mode(started.spec).frequency;
    const double mode = run::lightly_damped_mode(fit::computed_case(fit.model)).frequency;
    // A stem that is not stable when straight has no such mode.
    if (std::isnan(mode) || (mode < largest_ratio * swing && swing < largest_ratio * mode))
        return;
    throw core::NumericalError(
        core::FailureKind::FitFailed,
        fmt::format("{}: the first mode of the fitted chain has {:.4g} Hz, but the stem swings at "
                    "{:.4g} Hz (Eq. 1): time 0 is not the release, or the deflections do not count "
                    "from the rest position (culm import finds both)",
                    measurement.stem.id, mode, swing));
}

/// The last model of fit_nested().
fit::Fit fitted(const measure::Measurement& measurement, const CalibrationOptions& options) {
    if (measurement.release == measure::ReleaseKind::HeldStraight && options.effects.empty())
        throw core::InputError(
            fmt::format("{}: [release] kind = \"held_straight\": nothing moves such a stem in a "
                        "model without gravity; add --with gravity",
                        measurement.stem.id));
    std::vector<fit::SelectedEffects> sets;
    if (!options.effects.empty())
        sets.push_back(options.effects);
    fit::Fit model =
        std::move(diagnose::fit_nested({&measurement, 1}, sets, options.fit).models.back());
    if (!model.reason.empty()) // also a parameter at its bound is not calibrated
        throw core::NumericalError(core::FailureKind::FitFailed,
                                   fmt::format("{}: {}", measurement.stem.id, model.reason));
    require_swing(measurement, model.parts.front(), options);
    return model;
}

} // namespace

CalibrationCheck check_calibration(const fit::StemModel& model,
                                   const measure::Measurement& measurement,
                                   const reduce::RingDownOptions& options,
                                   run::IntegrationMethod method) {
    CalibrationCheck check;
    check.measured = reduce::fit_stem(residuals::histories_of(measurement), options);
    check.simulated = reduce::fit_stem(simulated_histories(model, measurement, method), options);
    check.decay_per_cycle = paired_mean(check, &reduce::RingDownFit::decay_per_cycle);
    check.frequency = paired_mean(check, &reduce::RingDownFit::frequency);
    if (std::isinf(check.decay_per_cycle.standard_error))
        throw core::NumericalError(
            core::FailureKind::FitFailed,
            fmt::format("{}: Eq. 1 cannot be fitted at any height", measurement.stem.id));
    return check;
}

Calibration calibrate_stem(const measure::Measurement& measurement,
                           const CalibrationOptions& options) {
    Calibration result;
    result.id = measurement.stem.id;
    result.stem = measurement.stem;
    result.fit = fitted(measurement, options);
    result.budget = fit::uncertainty_budget(result.fit, measurement);
    const run::CaseSpec chain = fit::computed_case(result.part().model);
    result.mode = run::first_mode(chain);
    const Eigen::VectorXd errors =
        fit::uncertainties_of(result.fit, result.budget, [](const run::CaseSpec& spec) {
            const integrate::VibrationMode mode = run::first_mode(spec);
            return Eigen::VectorXd{{mode.frequency, mode.decay_per_cycle}};
        });
    result.frequency = reduce::normal_estimate(result.mode.frequency, errors(0));
    result.decay_per_cycle = reduce::normal_estimate(result.mode.decay_per_cycle, errors(1));
    result.damping_time = fit::damping_time(chain);
    result.verdict =
        diagnose::verdict_on(result.part(), residuals::swing_of(result.part(), measurement));
    if (options.with_check) {
        try {
            result.check =
                check_calibration(result.part().model, measurement,
                                  check_options(measurement, options), options.check_method);
        } catch (const core::NumericalError& error) {
            result.check_failure = error.what();
        }
    }
    return result;
}

} // namespace culm::calibrate
