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

/// Mean of two series with the first one's weights, and the mean's standard error.
class PairedMean {
  public:
    void add(const reduce::Estimate& measured, const reduce::Estimate& simulated) {
        // Both means use the weights of the measurement: a height where it is uncertain must not
        // change the simulated mean alone.
        const double weight = 1.0 / (measured.standard_error * measured.standard_error);
        weights_ += weight;
        measured_ += weight * measured.value;
        simulated_ += weight * simulated.value;
    }
    [[nodiscard]] bool is_empty() const { return weights_ == 0.0; }
    [[nodiscard]] double measured() const { return measured_ / weights_; }
    [[nodiscard]] double simulated() const { return simulated_ / weights_; }
    [[nodiscard]] double error() const { return simulated_ / measured_ - 1.0; }
    [[nodiscard]] double resolution() const {
        return 1.0 / std::sqrt(weights_) / std::abs(measured());
    }

  private:
    double weights_ = 0.0;
    double measured_ = 0.0;
    double simulated_ = 0.0;
};

} // namespace

CalibrationCheck check_calibration(const fit::RecordingFit& fit,
                                   const measure::Measurement& measurement,
                                   const reduce::RingDownAnalysisOptions& options,
                                   const run::Integrator& integrator) {
    CalibrationCheck check;
    check.measured = reduce::fit_stem(residuals::histories_of(measurement), options);
    check.simulated =
        reduce::fit_stem(simulated_histories(fit.model, measurement, integrator), options);
    PairedMean decay;
    PairedMean frequency;
    for (std::size_t j = 0; j < check.measured.heights.size(); ++j) {
        const auto& measured = check.measured.heights[j].fit;
        const auto& simulated = check.simulated.heights[j].fit;
        if (!measured || !simulated)
            continue;
        decay.add(measured->decay_per_cycle, simulated->decay_per_cycle);
        frequency.add(measured->frequency, simulated->frequency);
    }
    if (decay.is_empty())
        throw core::NumericalError(
            core::FailureKind::FitFailed,
            fmt::format("{}: Eq. 1 cannot be fitted at any height", measurement.stem.id));
    check.measured_decay_per_cycle = decay.measured();
    check.simulated_decay_per_cycle = decay.simulated();
    check.decay_error = decay.error();
    check.decay_resolution = decay.resolution();
    check.measured_frequency = frequency.measured();
    check.simulated_frequency = frequency.simulated();
    check.frequency_error = frequency.error();
    check.frequency_resolution = frequency.resolution();
    return check;
}

} // namespace culm::calibrate
