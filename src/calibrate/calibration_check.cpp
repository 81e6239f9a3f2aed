// SPDX-License-Identifier: BSD-3-Clause
#include "calibrate/calibration.hpp"
#include "core/error.hpp"
#include "residuals/ring_downs.hpp"

#include <cmath>

#include <fmt/core.h>

namespace culm::calibrate {
namespace {

/// Readings of the model at all measured heights and times.
reduce::StemHistories simulated_histories(fit::StemModel model,
                                          const measure::Measurement& measurement,
                                          const run::Integrator& integrator) {
    // The fit is finished: without derivatives any integrator may be used.
    model.parameters.clear();
    model.release_time_bound = 0.0;
    model.spec.integrator.method = integrator.method;
    model.spec.integrator.solver = integrator.solver;
    reduce::StemHistories stem = residuals::histories_of(measurement);
    const fit::ChainPrediction prediction = predict_readings(model, measurement.times);
    for (std::size_t j = 0; j < stem.heights.size(); ++j)
        for (std::size_t i = 0; i < stem.times.size(); ++i)
            if (!std::isnan(stem.histories[j][i]))
                stem.histories[j][i] = prediction.readings[i * prediction.rows + j];
    return stem;
}

/// Means of a quantity over the heights that both stems' fits have, and the error of the measured
/// one; the weights are NaN if there are none.
struct PairedMean {
    double measured;
    double simulated;
    double standard_error;
};

PairedMean paired_mean(const CalibrationCheck& check,
                       reduce::Estimate reduce::RingDownAnalysis::*quantity) {
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

} // namespace

CalibrationCheck check_calibration(const fit::RecordingFit& fit,
                                   const measure::Measurement& measurement,
                                   const reduce::RingDownAnalysisOptions& options,
                                   const run::Integrator& integrator) {
    CalibrationCheck check;
    check.measured = reduce::fit_stem(residuals::histories_of(measurement), options);
    check.simulated =
        reduce::fit_stem(simulated_histories(fit.model, measurement, integrator), options);
    const PairedMean decay = paired_mean(check, &reduce::RingDownAnalysis::decay_per_cycle);
    const PairedMean frequency = paired_mean(check, &reduce::RingDownAnalysis::frequency);
    if (std::isinf(decay.standard_error))
        throw core::NumericalError(
            core::FailureKind::FitFailed,
            fmt::format("{}: Eq. 1 cannot be fitted at any height", measurement.stem.id));
    check.measured_decay_per_cycle = decay.measured;
    check.simulated_decay_per_cycle = decay.simulated;
    check.decay_error = decay.simulated / decay.measured - 1.0;
    check.decay_resolution = decay.standard_error / std::abs(decay.measured);
    check.measured_frequency = frequency.measured;
    check.simulated_frequency = frequency.simulated;
    check.frequency_error = frequency.simulated / frequency.measured - 1.0;
    check.frequency_resolution = frequency.standard_error / std::abs(frequency.measured);
    return check;
}

} // namespace culm::calibrate
