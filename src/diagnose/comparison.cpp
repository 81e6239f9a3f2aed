// SPDX-License-Identifier: BSD-3-Clause
#include "diagnose/comparison.hpp"

#include "calibrate/calibration_check.hpp"

#include <algorithm>
#include <cmath>

namespace culm::diagnose {
namespace {

constexpr std::size_t parts = 3;

/// Eq. 1 wants a release from rest in the line of time: a phase is free on both sides alike.
reduce::RingDownAnalysisOptions ring_down_options(const measure::Measurement& measurement,
                                                  const fit::RecordingFit& fit) {
    reduce::RingDownAnalysisOptions options;
    options.window = fit.times.back();
    options.has_phase = true;
    options.has_offset = measurement.release == measure::ReleaseKind::HeldStraight ||
                         !fit.model.spec.effects.empty();
    return options;
}

/// The model's readings in place of the measured ones.
reduce::StemHistories modelled_histories(const fit::RecordingFit& fit, reduce::StemHistories stem) {
    const std::size_t rows = fit.prediction.rows;
    stem.times.resize(fit.times.size());
    for (std::size_t j = 0; j < rows; ++j) {
        stem.histories[j].resize(fit.times.size());
        for (std::size_t i = 0; i < fit.times.size(); ++i)
            if (!std::isnan(stem.histories[j][i]))
                stem.histories[j][i] = fit.prediction.readings[i * rows + j];
    }
    return stem;
}

} // namespace

Comparison compare(const fit::Fit& candidate, const measure::Measurement& measurement) {
    const fit::RecordingFit& fit = candidate.parts.front();
    Comparison result;
    result.moves = candidate.moves();
    result.id = measurement.stem.id;
    result.swing = swing_of(fit, measurement);
    result.verdict = judge(fit, result.swing);
    result.by_height = residuals_by_height(fit);
    result.by_time = residuals_by_time(fit, parts);
    result.spectrum = residual_spectrum(fit);
    result.windows = swing_windows(result.swing);
    result.by_amplitude =
        residuals_by_amplitude(fit, envelope(result.swing, result.windows), parts);
    result.modes = mode_shapes(fit, measurement);
    result.structure = residual_structure(fit, result.swing);
    const reduce::RingDownAnalysisOptions options = ring_down_options(measurement, fit);
    const reduce::StemHistories measured = calibrate::histories_of(measurement);
    result.measured_ring_downs = reduce::fit_stem(measured, options);
    result.modelled_ring_downs = reduce::fit_stem(modelled_histories(fit, measured), options);
    return result;
}

} // namespace culm::diagnose
