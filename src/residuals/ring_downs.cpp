// SPDX-License-Identifier: BSD-3-Clause
#include "residuals/ring_downs.hpp"

#include <cmath>
#include <utility>

namespace culm::residuals {
namespace {

/// Eq. 1 assumes a release from rest at time 0; measurement and model get a free phase alike.
reduce::RingDownAnalysisOptions ring_down_options(const measure::Measurement& measurement,
                                                  const fit::RecordingFit& fit) {
    reduce::RingDownAnalysisOptions options;
    options.window = fit.times.back();
    options.has_phase = true;
    options.has_offset = measurement.release == measure::ReleaseKind::HeldStraight ||
                         !fit.model.spec.effects.empty();
    return options;
}

/// The histories with the model's readings instead of the measured ones.
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

reduce::StemHistories histories_of(const measure::Measurement& measurement) {
    reduce::StemHistories stem;
    stem.id = measurement.stem.id;
    const measure::ReadingUnit unit = measure::reading_unit(measurement.sensors);
    stem.unit = {unit.factor, std::string(unit.name)};
    stem.length = measurement.stem.length;
    stem.depth = measure::section_depth(measurement.stem.section);
    stem.times = measurement.times;
    stem.heights = measurement.heights;
    for (std::size_t j = 0; j < measurement.heights.size(); ++j) {
        stem.histories.push_back(measurement.history(j));
        stem.noise.push_back(measurement.noise_at(j));
    }
    return stem;
}

RingDownsOfBoth ring_downs_of_both(const fit::RecordingFit& fit,
                                   const measure::Measurement& measurement) {
    const reduce::RingDownAnalysisOptions options = ring_down_options(measurement, fit);
    const reduce::StemHistories measured = histories_of(measurement);
    return {reduce::fit_stem(measured, options),
            reduce::fit_stem(modelled_histories(fit, measured), options)};
}

} // namespace culm::residuals
