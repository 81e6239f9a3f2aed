// SPDX-License-Identifier: BSD-3-Clause
#include "fit/noise/reading_noise.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/core.h>

namespace culm::fit {

namespace {

constexpr std::size_t fewest_degrees_of_freedom = 20;

/// A sum of squares with its degrees of freedom.
struct Scatter {
    double sum_of_squares = 0.0;
    std::size_t degrees_of_freedom = 0;

    [[nodiscard]] double deviation() const {
        return std::sqrt(sum_of_squares / static_cast<double>(degrees_of_freedom));
    }
};

/// Rows with a common noise: all rows of a camera; each sensor has its own.
std::size_t rows_of_one_noise(const measure::Measurement& measurement) {
    return measurement.sensors.empty() ? measurement.heights.size() : 1;
}

/// Scatter about the mean of each row from `first` on that has the same noise, in frames [begin,
/// end).
Scatter scatter_about_means(const measure::Measurement& measurement, std::size_t first,
                            std::size_t begin, std::size_t end) {
    Scatter scatter;
    for (std::size_t j = first; j < first + rows_of_one_noise(measurement); ++j) {
        double sum = 0.0;
        double sum_of_squares = 0.0;
        std::size_t count = 0;
        for (std::size_t i = begin; i < end; ++i) {
            const double reading = measurement.deflection(i, j);
            if (std::isnan(reading))
                continue;
            const double mean = count == 0 ? reading : sum / static_cast<double>(count);
            sum += reading;
            ++count;
            sum_of_squares += (reading - mean) * (reading - sum / static_cast<double>(count));
        }
        if (count > 1) {
            scatter.sum_of_squares += sum_of_squares;
            scatter.degrees_of_freedom += count - 1;
        }
    }
    return scatter;
}

/// Scatter of the second differences, which are insensitive to a slow motion. White noise has 6
/// times its variance in them.
Scatter scatter_of_second_differences(const measure::Measurement& measurement, std::size_t first,
                                      std::size_t begin, std::size_t end) {
    Scatter scatter;
    for (std::size_t j = first; j < first + rows_of_one_noise(measurement); ++j)
        for (std::size_t i = begin + 2; i < end; ++i) {
            const double difference = measurement.deflection(i, j) -
                                      2.0 * measurement.deflection(i - 1, j) +
                                      measurement.deflection(i - 2, j);
            if (std::isnan(difference))
                continue;
            scatter.sum_of_squares += difference * difference / 6.0;
            ++scatter.degrees_of_freedom;
        }
    return scatter;
}

/// Root mean square of the stated uncertainties of each row's readings, (rows), m.
std::vector<double> mean_uncertainties(const measure::Measurement& measurement) {
    const std::size_t rows = measurement.heights.size();
    std::vector<double> means;
    for (std::size_t j = 0; j < rows; ++j) {
        double sum = 0.0;
        double count = 0.0;
        for (std::size_t at = j; at < measurement.deflections.size(); at += rows)
            if (!std::isnan(measurement.deflections[at])) {
                sum += std::pow(measurement.reading_uncertainties[at], 2);
                count += 1.0;
            }
        means.push_back(std::sqrt(sum / std::max(count, 1.0)));
    }
    return means;
}

/// (rows); empty if the first `held` frames do not determine it.
std::vector<double> noise_while_held(const measure::Measurement& measurement, std::size_t held) {
    std::vector<double> noise;
    const std::size_t rows = rows_of_one_noise(measurement);
    for (std::size_t first = 0; first < measurement.heights.size(); first += rows) {
        const Scatter before = scatter_about_means(measurement, first, 0, held);
        if (before.degrees_of_freedom < fewest_degrees_of_freedom || !(before.sum_of_squares > 0.0))
            return {};
        noise.insert(noise.end(), rows, before.deviation());
    }
    return noise;
}

/// (rows); empty if the stem is not at rest in the frames from `begin` on.
std::vector<double> noise_at_rest(const measure::Measurement& measurement, std::size_t begin) {
    const std::size_t end = measurement.times.size();
    std::vector<double> noise;
    const std::size_t rows = rows_of_one_noise(measurement);
    for (std::size_t first = 0; first < measurement.heights.size(); first += rows) {
        const Scatter about_mean = scatter_about_means(measurement, first, begin, end);
        const Scatter differences = scatter_of_second_differences(measurement, first, begin, end);
        if (differences.degrees_of_freedom < 2 * fewest_degrees_of_freedom ||
            !(differences.sum_of_squares > 0.0) ||
            !(about_mean.deviation() < 1.2 * differences.deviation()))
            return {};
        noise.insert(noise.end(), rows, about_mean.deviation());
    }
    return noise;
}

} // namespace

ReadingNoise reading_noise(const ObservedRecording& measurement) {
    const std::size_t rows = measurement.heights.size();
    const std::size_t frames = measurement.times.size();
    ReadingNoise noise;
    if (measurement.noise_model && !measurement.noise_model->by_row.empty())
        return {measurement.noise_model->by_row, measurement.noise_model->source};
    if (!measurement.reading_uncertainties.empty() && !measurement.noise_model)
        return {mean_uncertainties(measurement), "stated for every reading"};
    for (std::size_t j = 0; j < rows; ++j)
        if (const auto stated = measurement.noise_at(j); stated && *stated > 0.0)
            noise.by_row.push_back(*stated);
    if (noise.by_row.size() == rows && rows > 0) {
        noise.source =
            measurement.noise_source.empty() ? "stated" : "stated: " + measurement.noise_source;
        return noise;
    }
    noise.by_row.clear();

    // The frame at the release itself, and the one before it, may already have moved.
    std::size_t held = 0;
    while (held < frames && measurement.times[held] < 0.0)
        ++held;
    held -= held > 0 ? 1 : 0;
    if (noise.by_row = noise_while_held(measurement, held); !noise.by_row.empty()) {
        noise.source = fmt::format("{} frames while the stem was held", held);
        return noise;
    }
    const std::size_t tail = frames / 10;
    if (noise.by_row = noise_at_rest(measurement, frames - tail); !noise.by_row.empty())
        noise.source = fmt::format("the last {} frames, at rest", tail);
    return noise;
}

std::vector<double> relative_noise(const measure::Measurement& measurement,
                                   const std::vector<double>& by_row) {
    std::vector<double> relative = measurement.reading_uncertainties;
    for (std::size_t at = 0; at < relative.size(); ++at)
        relative[at] /= by_row[at % by_row.size()];
    return relative;
}

} // namespace culm::fit
