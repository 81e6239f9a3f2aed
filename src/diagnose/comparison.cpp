// SPDX-License-Identifier: BSD-3-Clause
#include "diagnose/comparison.hpp"

#include "residuals/ring_downs.hpp"

#include <utility>

namespace culm::diagnose {

Comparison compare(const fit::Fit& stated, const fit::Fit& judged,
                   const measure::Measurement& measurement, const Policy& policy) {
    constexpr std::size_t parts = 3;
    const fit::RecordingFit& fit = stated.parts.front();
    const fit::RecordingFit& tested = judged.parts.front();
    Comparison result;
    result.moves = stated.moves();
    result.id = measurement.stem.id;
    result.swing = residuals::swing_of(fit, measurement);
    result.verdict = verdict_on(tested, residuals::swing_of(tested, measurement), policy);
    result.unit = measure::reading_unit(measurement.sensors);
    result.rmse = fit.rmse;
    result.noise = typical_noise(fit);
    result.over_noise = over_noise(fit);
    result.by_height = residuals_by_height(fit);
    result.by_time = residuals_by_time(fit, parts);
    result.spectrum = residual_spectrum(fit);
    result.windows = residuals::swing_windows(result.swing);
    result.by_amplitude =
        residuals_by_amplitude(fit, residuals::envelope(result.swing, result.windows), parts);
    result.structure = residuals::residual_structure(fit, result.swing);
    residuals::RingDownsOfBoth ring_downs = residuals::ring_downs_of_both(fit, measurement);
    result.measured_ring_downs = std::move(ring_downs.measured);
    result.modelled_ring_downs = std::move(ring_downs.modelled);
    return result;
}

} // namespace culm::diagnose
