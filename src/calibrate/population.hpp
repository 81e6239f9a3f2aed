// SPDX-License-Identifier: BSD-3-Clause
// The spread of calibrated stems.
#pragma once

#include "calibrate/calibration.hpp"
#include "reduce/population_statistics.hpp"

#include <cstddef>
#include <optional>
#include <span>

namespace culm::calibrate {

/// A stem's contribution to the population, which is sent between ranks.
struct StemNumbers {
    double bond_youngs_modulus = 0.0; ///< Pa
    double bond_damping = 0.0;
    double decay_per_cycle = 0.0;
    double frequency = 0.0; ///< Hz
    bool is_adequate = false;
};

[[nodiscard]] StemNumbers numbers_of(const Calibration& calibration);

/// The population of two or more calibrated stems.
struct Population {
    std::size_t stems = 0; ///< calibrated
    std::size_t failed = 0;
    std::size_t inadequate = 0;
    reduce::SampleSummary bond_youngs_modulus; ///< Pa
    reduce::SampleSummary bond_damping;
    reduce::SampleSummary decay_per_cycle;
    reduce::SampleSummary frequency; ///< Hz
};

template <class To>
void describe(To& to, const Population& population) {
    to("stems", population.stems);
    to("failed", population.failed);
    to("something_missing", population.inadequate);
    to("bond_youngs_modulus_pa", population.bond_youngs_modulus);
    to("bond_damping", population.bond_damping);
    to("b1_per_cycle", population.decay_per_cycle);
    to("b2_hz", population.frequency);
}

/// Returns nothing for fewer than two calibrated stems.
[[nodiscard]] std::optional<Population> population_of(std::span<const StemNumbers> calibrated,
                                                      std::size_t failed);

} // namespace culm::calibrate
