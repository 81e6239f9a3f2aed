// SPDX-License-Identifier: BSD-3-Clause
#include "residuals/stem_ring_downs.hpp"

#include "core/error.hpp"
#include "reduce/distributions.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

namespace culm::residuals {

namespace {

/// See StemRingDowns::frequency.
std::optional<reduce::Estimate> weighted_mean(const std::vector<reduce::Estimate>& estimates) {
    double weights = 0.0;
    double sum = 0.0;
    // Weights 1/s² give the mean of least variance, 1/Σ 1/s².
    for (const reduce::Estimate& estimate : estimates) {
        const double weight = 1.0 / (estimate.standard_error * estimate.standard_error);
        weights += weight;
        sum += weight * estimate.value;
    }
    if (!(weights > 0.0) || !std::isfinite(weights))
        return std::nullopt;
    const double mean = sum / weights;
    double scatter = 0.0;
    for (const reduce::Estimate& estimate : estimates)
        scatter += std::pow((estimate.value - mean) / estimate.standard_error, 2);
    const std::size_t freedom = estimates.size() - 1;
    // The Birge ratio (Birge 1932): where the heights scatter by more than their errors, the error
    // of the mean is multiplied by that factor. It never decreases.
    const double birge =
        freedom > 0 ? std::sqrt(std::max(1.0, scatter / static_cast<double>(freedom))) : 1.0;
    const double error = birge / std::sqrt(weights);
    // Each height has many samples; the scatter between heights has few degrees of freedom.
    const double factor = birge > 1.0 ? reduce::student_t_factor(freedom)
                                      : (estimates.front().upper - estimates.front().value) /
                                            estimates.front().standard_error;
    return reduce::Estimate{mean, error, mean - factor * error, mean + factor * error};
}

/// Relative heights and b1 per cycle of fitted heights, with the inverse variances as weights.
struct DecaysOverHeight {
    std::vector<double> places;
    std::vector<double> decays;
    std::vector<double> weights;

    void add(const StemRingDowns& stem) {
        for (const HeightRingDown& height : stem.heights)
            if (height.fit) {
                places.push_back(height.height / stem.length);
                decays.push_back(height.fit->decay_per_cycle.value);
                weights.push_back(std::pow(height.fit->decay_per_cycle.standard_error, -2));
            }
    }
};

HeightRingDown fit_height(const measure::Measurement& measurement, std::size_t index,
                          const std::vector<double>& history, reduce::RingDownOptions options) {
    HeightRingDown result;
    result.height = measurement.heights[index];
    options.is_measured = true;
    options.noise = measurement.noise_at(index);
    try {
        result.fit = reduce::fit_ring_down(measurement.times, history, options);
    } catch (const core::NumericalError& error) {
        result.failure = error.what();
    }
    return result;
}

void adjust_banding(std::vector<StemRingDowns>& stems, PopulationSummary& summary) {
    std::vector<double> p_values;
    std::vector<double> slopes;
    for (const StemRingDowns& stem : stems)
        if (stem.banding) {
            p_values.push_back(stem.banding->p_value);
            slopes.push_back(stem.banding->slope);
        }
    // Many stems are tested at once.
    const std::vector<double> adjusted = reduce::holm_adjusted(p_values);
    std::size_t next = 0;
    for (StemRingDowns& stem : stems)
        if (stem.banding) {
            stem.banding_adjusted_p_value = adjusted[next++];
            summary.banded_stems +=
                stem.banding_adjusted_p_value < 1.0 - reduce::confidence_level ? 1U : 0U;
        }
    summary.banding_slopes = reduce::summarise(slopes);
    if (slopes.size() > 1) {
        const double error = summary.banding_slopes.standard_deviation /
                             std::sqrt(static_cast<double>(slopes.size()));
        summary.mean_slope_p_value =
            reduce::student_t_p_value(summary.banding_slopes.mean / error, slopes.size() - 1);
    }
}

} // namespace

StemRingDowns fit_stem(const measure::Measurement& measurement,
                       const reduce::RingDownOptions& options) {
    StemRingDowns result;
    result.id = measurement.stem.id;
    result.unit = measure::reading_unit(measurement.sensors);
    result.length = measurement.stem.length;
    result.aspect_ratio = result.length / measure::section_depth(measurement.stem.section);
    std::vector<reduce::Estimate> frequencies;
    std::vector<reduce::Estimate> decays;
    for (std::size_t j = 0; j < measurement.heights.size(); ++j) {
        const std::vector<double> history = measurement.history(j);
        for (const double deflection : history)
            if (!std::isnan(deflection))
                result.largest_deflection =
                    std::max(result.largest_deflection, std::abs(deflection));
        result.heights.push_back(fit_height(measurement, j, history, options));
        const HeightRingDown& height = result.heights.back();
        if (!height.fit)
            continue;
        frequencies.push_back(height.fit->frequency);
        decays.push_back(height.fit->decay_per_cycle);
        result.adequate_heights += height.fit->adequacy.is_adequate ? 1U : 0U;
    }
    if (!frequencies.empty()) {
        result.frequency = weighted_mean(frequencies);
        result.decay_per_cycle = weighted_mean(decays);
    }
    // One mode of a linear stem has the same b1 at every height.
    DecaysOverHeight found;
    found.add(result);
    if (const reduce::LineFit line = reduce::fit_line(found.places, found.decays, found.weights);
        line.count > 0)
        result.banding = line;
    return result;
}

PopulationSummary summarise_population(std::vector<StemRingDowns>& stems) {
    const auto collect = [&stems](const auto& value_of) {
        std::vector<double> values;
        for (const StemRingDowns& stem : stems)
            if (stem.frequency && stem.decay_per_cycle)
                values.push_back(std::invoke(value_of, stem));
        return values;
    };
    const auto frequency = [](const StemRingDowns& stem) { return stem.frequency->value; };
    const auto decay = [](const StemRingDowns& stem) { return stem.decay_per_cycle->value; };
    // f0 = b2 √(1 + (δ/2π)²), δ = −b1 per cycle.
    const auto natural_frequency = [&](const StemRingDowns& stem) {
        return frequency(stem) * std::hypot(1.0, decay(stem) / (2.0 * std::numbers::pi));
    };
    const std::vector<double> decays = collect(decay);
    const std::vector<double> aspect_ratios = collect(&StemRingDowns::aspect_ratio);
    PopulationSummary summary;
    summary.stems = decays.size();
    summary.frequency = reduce::summarise(collect(frequency));
    summary.decay_per_cycle = reduce::summarise(decays);
    summary.natural_frequency = reduce::summarise(collect(natural_frequency));
    summary.largest_deflection = reduce::summarise(collect(&StemRingDowns::largest_deflection));
    summary.length = reduce::summarise(collect(&StemRingDowns::length));
    summary.aspect_ratio = reduce::summarise(aspect_ratios);
    summary.decay_against_aspect_ratio = reduce::fit_line(aspect_ratios, decays);
    DecaysOverHeight pooled;
    for (const StemRingDowns& stem : stems)
        pooled.add(stem);
    summary.decay_against_height = reduce::fit_line(pooled.places, pooled.decays);
    adjust_banding(stems, summary);
    return summary;
}

} // namespace culm::residuals
