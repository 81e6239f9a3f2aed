// SPDX-License-Identifier: BSD-3-Clause
#include "residuals/ring_downs.hpp"

#include <cmath>
#include <string>
#include <vector>

namespace culm::residuals {
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
    // Eq. 1 assumes a release from rest at time 0; measurement and model get a free phase alike.
    reduce::RingDownAnalysisOptions options;
    options.window = fit.times.back();
    options.has_phase = true;
    options.has_offset = measurement.release == measure::ReleaseKind::HeldStraight ||
                         !fit.model.spec.effects.empty();
    const reduce::StemHistories measured = histories_of(measurement);
    reduce::StemHistories modelled = measured;
    modelled.times.resize(fit.times.size());
    for (std::size_t j = 0; j < fit.prediction.rows; ++j) {
        std::vector<double>& history = modelled.histories[j];
        history.resize(fit.times.size());
        for (std::size_t i = 0; i < fit.times.size(); ++i)
            if (!std::isnan(history[i]))
                history[i] = fit.prediction.readings[i * fit.prediction.rows + j];
    }
    return {reduce::fit_stem(measured, options), reduce::fit_stem(modelled, options)};
}

} // namespace culm::residuals
