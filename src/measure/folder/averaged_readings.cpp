// SPDX-License-Identifier: BSD-3-Clause
// Fewer readings of a record that is sampled far faster than its stem swings.
#include "core/order_statistics.hpp"
#include "measure/folder/measurement_files.hpp"
#include "measure/release/swing_release.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/core.h>

namespace culm::measure {

namespace {

/// A mean over a 60th of a cycle is smaller than the middle value by 0.05 %.
constexpr double wanted_per_cycle = 60.0;
/// Second frequency of a cantilever over the first, (4.6941/1.8751)².
constexpr double second_mode = 6.267;
constexpr std::size_t most_unaveraged = 20'000; ///< times: fewer cost little

/// Readings per cycle of the first mode, or of a higher one that dominates at every height.
double readings_per_cycle(const Measurement& measurement) {
    double lowest = 0.0;
    for (std::size_t j = 0; j < measurement.heights.size(); ++j)
        if (const double found = passage_frequency(measurement.times, measurement.history(j));
            found > 0.0 && (lowest == 0.0 || found < lowest))
            lowest = found;
    return lowest > 0.0 ? 1.0 / (lowest * core::median_interval(measurement.times)) : 0.0;
}

/// The largest number up to `most` without prime factors above 5, of which a Fourier transform is
/// fast.
std::size_t smooth_number(std::size_t most) {
    std::size_t best = 1;
    for (std::size_t five = 1; five <= most; five *= 5)
        for (std::size_t three = five; three <= most; three *= 3) {
            std::size_t two = three;
            while (2 * two <= most)
                two *= 2;
            best = std::max(best, two);
        }
    return best;
}

/// First index of each group of `size` times, and the end. No group contains the release. A few
/// readings at the end are left out: the number of groups after the release is a smooth one.
std::vector<std::size_t> groups_of(const std::vector<double>& times, std::size_t size) {
    const auto release = std::size_t(std::ranges::lower_bound(times, 0.0) - times.begin());
    const std::size_t end = release + size * smooth_number((times.size() - release) / size);
    std::vector<std::size_t> begins;
    for (std::size_t k = release % size; k <= end; k += size)
        begins.push_back(k);
    return begins;
}

/// Mean of a part of a column; NaN if fewer than half are known. `power` 2: root mean square over
/// the root of their number, the uncertainty of the mean.
double mean_of(const std::vector<double>& values, std::size_t begin, std::size_t end,
               std::size_t stride, int power) {
    double sum = 0.0;
    double count = 0.0;
    for (std::size_t k = begin; k < end; k += stride)
        if (!std::isnan(values[k])) {
            sum += std::pow(values[k], power);
            count += 1.0;
        }
    if (2.0 * count * double(stride) < double(end - begin))
        return std::numeric_limits<double>::quiet_NaN();
    return power == 1 ? sum / count : std::sqrt(sum) / count;
}

/// Variance of a mean of n readings over that of one, and the correlation of neighbouring means,
/// for errors with the correlation r^k between readings k apart.
struct MeanErrors {
    double variance = 1.0;
    double correlation = 0.0;

    MeanErrors(double n, double r)
        : variance((n * (1.0 + r) / (1.0 - r) -
                    2.0 * r * (1.0 - std::pow(r, n)) / std::pow(1.0 - r, 2)) /
                   (n * n)),
          correlation(r * std::pow((1.0 - std::pow(r, n)) / (1.0 - r) / n, 2) / variance) {}
};

} // namespace

void average_readings(const std::string& name, Measurement& measurement) {
    const std::vector<double> times = measurement.times;
    const std::optional<int> wanted = measurement.readings_per_mean;
    if (!wanted && times.size() <= most_unaveraged)
        return;
    const double per_cycle = readings_per_cycle(measurement);
    const auto size = std::size_t(wanted.value_or(
        int(std::max(1.0, std::floor(per_cycle / (wanted_per_cycle * second_mode))))));
    if (size < 2 || 12.0 * double(size) > double(std::ranges::count_if(
                                              times, [](double time) { return time >= 0.0; })))
        return;
    const std::vector<std::size_t> groups = groups_of(times, size);
    const std::size_t columns = measurement.heights.size();
    const auto averaged = [&](const std::vector<double>& values, std::size_t stride, int power) {
        std::vector<double> means;
        for (std::size_t g = 0; g + 1 < groups.size(); ++g)
            for (std::size_t j = 0; j < stride; ++j)
                means.push_back(
                    mean_of(values, groups[g] * stride + j, groups[g + 1] * stride, stride, power));
        return means;
    };
    measurement.times = averaged(times, 1, 1);
    measurement.deflections = averaged(measurement.deflections, columns, 1);
    if (!measurement.reading_uncertainties.empty())
        measurement.reading_uncertainties = averaged(measurement.reading_uncertainties, columns, 2);
    const MeanErrors errors(double(size), measurement.noise_correlation.value_or(0.0));
    if (measurement.noise_correlation)
        measurement.noise_correlation = errors.correlation;
    const double factor = std::sqrt(errors.variance);
    // Noise that is not white averages out less; a still part shows it.
    const auto of_mean = [&](double noise, std::size_t j) {
        return std::max(factor * noise, quietest_noise(measurement.times, measurement.history(j)));
    };
    if (measurement.noise)
        measurement.noise = of_mean(*measurement.noise, columns - 1);
    for (std::size_t j = 0; j < measurement.noise_by_height.size(); ++j)
        measurement.noise_by_height[j] = of_mean(measurement.noise_by_height[j], j);
    for (std::size_t j = 0; j < measurement.sensors.size(); ++j)
        if (measurement.sensors[j].noise)
            measurement.sensors[j].noise = of_mean(*measurement.sensors[j].noise, j);
    const std::optional<double> noise = measurement.noise_at(columns - 1);
    measurement.remarks.push_back(fmt::format(
        "{}: {} readings, {:.4g} per cycle, are averaged in groups of {}{} ([measurement] "
        "readings_per_mean)",
        name, times.size(), per_cycle, size,
        noise ? fmt::format("; the noise of a mean is {}",
                            reading_unit(measurement.sensors).text(*noise))
              : std::string()));
}

} // namespace culm::measure
