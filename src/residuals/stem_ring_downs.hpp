// SPDX-License-Identifier: BSD-3-Clause
// The laboratory results: Eq. 1 at every height of a stem, and statistics of a population.
#pragma once

#include "measure/folder/measurement.hpp"
#include "reduce/population_statistics.hpp"
#include "reduce/ring_down/ring_down_fit.hpp"

#include <optional>
#include <string>
#include <vector>

namespace culm::residuals {

struct HeightRingDown {
    double height = 0.0; ///< m
    std::optional<reduce::RingDownFit> fit;
    std::string failure; ///< why there is no fit
};

struct StemRingDowns {
    std::string id;
    measure::ReadingUnit unit;       ///< in which deflections are printed
    double length = 0.0;             ///< m
    double aspect_ratio = 0.0;       ///< length over depth
    double largest_deflection = 0.0; ///< of all readings, before the release too, m
    std::vector<HeightRingDown> heights;
    /// Means over the heights, weighted by the inverse variances; their errors are enlarged by the
    /// scatter between the heights where that is larger (Birge 1932). Empty if no height could be
    /// fitted.
    std::optional<reduce::Estimate> frequency;       ///< b2, Hz
    std::optional<reduce::Estimate> decay_per_cycle; ///< b1/b2
    /// b1 per cycle along the relative height h/length ("banding"); empty with fewer than three
    /// fitted heights.
    std::optional<reduce::LineFit> banding;
    double banding_adjusted_p_value = 1.0; ///< for the number of stems tested together
    std::size_t adequate_heights = 0;
};

[[nodiscard]] StemRingDowns fit_stem(const measure::Measurement& measurement,
                                     const reduce::RingDownOptions& options);

/// Statistics of a set of stems; stems without a fit are left out.
struct PopulationSummary {
    std::size_t stems = 0;           ///< with a fit
    reduce::SampleSummary frequency; ///< Hz
    reduce::SampleSummary decay_per_cycle;
    reduce::SampleSummary natural_frequency; ///< undamped, b2 √(1 + (b1/2π)²) with b1 per cycle, Hz
    reduce::SampleSummary largest_deflection; ///< m
    reduce::SampleSummary length;             ///< m
    reduce::SampleSummary aspect_ratio;
    reduce::LineFit decay_against_aspect_ratio; ///< the paper's Fig. 6b
    reduce::LineFit decay_against_height; ///< all heights of all stems, relative height: Fig. 6a
    /// Slopes of banding of the single stems; the test is whether their mean is zero.
    reduce::SampleSummary banding_slopes;
    double mean_slope_p_value = 1.0; ///< Student's t over stems
    std::size_t banded_stems = 0;    ///< whose slope is significant (5 %) after Holm's adjustment
};

/// Summarises, and sets banding_adjusted_p_value of each stem.
[[nodiscard]] PopulationSummary summarise_population(std::vector<StemRingDowns>& stems);

} // namespace culm::residuals
