// SPDX-License-Identifier: BSD-3-Clause
// Measurements made by the chain itself, with noise of known size.
#pragma once

#include "fit/chain/prediction.hpp"
#include "measure/folder/measurement.hpp"

#include <random>

namespace culm::tests {

/// A stem of Table 1 of the paper, 20 spheres to be quick, seen at 1000 frames/s in four rows for
/// 0.15 s, with five frames before the release; no readings yet.
inline measure::Measurement empty_measurement() {
    measure::Measurement measurement;
    measurement.stem.id = "simulated";
    measurement.stem.length = 0.15565;
    measurement.stem.section = measure::CircularSection{2.83e-3, {}};
    measurement.stem.density = 125.0;
    measurement.stem.spheres = 20;
    measurement.frames_per_second = 1000.0;
    measurement.noise = 0.05e-3;
    measurement.heights = {0.04, 0.08, 0.12, 0.15};
    for (int frame = -5; frame < 150; ++frame)
        measurement.times.push_back(1e-3 * frame);
    measurement.deflections.assign(measurement.times.size() * measurement.heights.size(), 0.0);
    return measurement;
}

struct TrueValues {
    double bond_youngs_modulus = 1.3e9;
    double bond_damping = 12.0;
    double tip_deflection = 15e-3;
    double release_time = 0.4e-3;
};

/// The model whose readings `measurement` gets.
inline fit::StemModel true_model(const measure::Measurement& measurement,
                                 const TrueValues& values) {
    fit::StemModel model{fit::chain_of(measurement).spec,
                         fit::baseline_free_parameters(),
                         values.release_time,
                         1.5e-3,
                         {}};
    model.spec.stem.bond_youngs_modulus = values.bond_youngs_modulus;
    model.spec.stem.bond_damping = values.bond_damping;
    model.spec.tip_deflection = values.tip_deflection;
    model.spec.sample_interval = 1e-4;
    return model;
}

/// Readings of the model with Gaussian noise of the measurement's own size.
inline measure::Measurement read_with_noise(measure::Measurement measurement,
                                            const fit::StemModel& model, unsigned seed) {
    const fit::ChainPrediction truth = fit::predict_readings(model, measurement.times);
    std::mt19937 generator(seed);
    std::normal_distribution<double> noise(0.0, measurement.noise.value_or(0.05e-3));
    for (std::size_t k = 0; k < truth.readings.size(); ++k)
        measurement.deflections[k] = truth.readings[k] + noise(generator);
    return measurement;
}

inline measure::Measurement simulated_measurement(const TrueValues& values = {},
                                                  unsigned seed = 1) {
    const measure::Measurement measurement = empty_measurement();
    return read_with_noise(measurement, true_model(measurement, values), seed);
}

} // namespace culm::tests
