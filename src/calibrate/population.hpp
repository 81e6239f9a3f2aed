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

/// "90 % of the stems lie in lower … upper", with the 95 % range of either end over resampled
/// populations.
struct CentralRange {
    reduce::SampleSummary sample;
    reduce::Bounds lower_interval; ///< of the lower end of its central_90_percent, 95 %
    reduce::Bounds upper_interval;
};

template <class To>
void describe(To& to, const CentralRange& found) {
    describe(to, found.sample);
    to("central_90_percent_lower_interval", found.lower_interval, "by bootstrap");
    to("central_90_percent_upper_interval", found.upper_interval, "by bootstrap");
}

/// Quantiles with percentile bootstrap intervals (Efron 1979): `resamples` populations of the same
/// size drawn with replacement by a generator of fixed seed, so that the result is reproducible.
/// For few stems the ends are close to the extreme values, and the intervals are wide.
[[nodiscard]] CentralRange central_range(std::span<const double> values, int resamples = 4000);

/// The population of two or more calibrated stems.
struct Population {
    std::size_t stems = 0; ///< calibrated
    std::size_t failed = 0;
    std::size_t inadequate = 0;
    CentralRange bond_youngs_modulus; ///< Pa
    CentralRange bond_damping;
    CentralRange decay_per_cycle;
    CentralRange frequency; ///< Hz
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
