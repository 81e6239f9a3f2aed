// SPDX-License-Identifier: BSD-3-Clause
#include "measure/import/import_recording.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <Eigen/QR>

namespace culm::measure {

namespace {

/// Travel and its rate without the frames that have a gap.
struct Travel {
    std::vector<double> times;
    std::vector<double> positions;
    std::vector<double> rates;
};

Travel travel_of(std::span<const double> times, std::span<const double> positions) {
    Travel travel;
    for (std::size_t i = 0; i < times.size(); ++i)
        if (!std::isnan(positions[i])) {
            travel.times.push_back(times[i]);
            travel.positions.push_back(positions[i]);
        }
    travel.rates.assign(travel.times.size(), 0.0);
    for (std::size_t i = 1; i + 1 < travel.times.size(); ++i)
        travel.rates[i] = (travel.positions[i + 1] - travel.positions[i - 1]) /
                          (travel.times[i + 1] - travel.times[i - 1]);
    return travel;
}

/// The first frame from `from` on whose rate reaches this share of the largest.
std::size_t first_at(const Travel& travel, double share, std::size_t from) {
    double largest = 0.0;
    for (const double rate : travel.rates)
        largest = std::max(largest, std::abs(rate));
    while (from < travel.rates.size() && std::abs(travel.rates[from]) < share * largest)
        ++from;
    return from;
}

/// Sum of squared errors of a drift that is followed by 1 − cos ω(t − onset), over frames [begin,
/// end).
double squared_error(const Travel& travel, std::size_t begin, std::size_t end,
                     double angular_frequency, double onset) {
    const auto count = static_cast<Eigen::Index>(end - begin);
    Eigen::MatrixXd columns(count, 3);
    Eigen::VectorXd positions(count);
    for (Eigen::Index i = 0; i < count; ++i) {
        const std::size_t at = begin + static_cast<std::size_t>(i);
        const double since = std::max(travel.times[at] - onset, 0.0);
        columns.row(i) << 1.0, (travel.times[at] - travel.times[begin]) * angular_frequency,
            1.0 - std::cos(angular_frequency * since);
        positions(i) = travel.positions[at];
    }
    return (positions - columns * columns.colPivHouseholderQr().solve(positions)).squaredNorm();
}

} // namespace

std::optional<ReleaseOnset> release_onset(std::span<const double> times,
                                          std::span<const double> positions) {
    // A rate sin ω(t − t₀) reaches half of its maximum at ω(t − t₀) = 0.524, and nine tenths at
    // 1.120.
    constexpr double between = 1.120 - 0.524;
    constexpr std::size_t fewest_before = 5;
    constexpr int trials = 300;
    const Travel travel = travel_of(times, positions);
    const std::size_t half = first_at(travel, 0.5, 0);
    const std::size_t nearly_all = std::max(first_at(travel, 0.9, half), half + 1);
    if (half < fewest_before || nearly_all + 1 >= travel.times.size())
        return std::nullopt;
    const double unit = (travel.times[nearly_all] - travel.times[half]) / between; // 1/ω
    const double latest = travel.times[half];
    const double earliest = std::max(latest - 1.5 * unit, travel.times.front());
    const auto first = std::ranges::lower_bound(travel.times, latest - 4.0 * unit);
    const std::size_t begin =
        std::min(static_cast<std::size_t>(first - travel.times.begin()), half - fewest_before);
    // Of every time, the best frequency: the profile of the sum of squares.
    std::vector<double> errors(trials + 1, std::numeric_limits<double>::infinity());
    for (double factor = 0.6; factor < 1.6; factor *= 1.05)
        for (int k = 0; k <= trials; ++k) {
            double& error = errors[static_cast<std::size_t>(k)];
            error = std::min(error, squared_error(travel, begin, nearly_all + 1, factor / unit,
                                                  earliest + k * (latest - earliest) / trials));
        }
    const auto smallest = std::ranges::min_element(errors);
    const double least = *smallest;
    ReleaseOnset best;
    best.time =
        earliest + static_cast<double>(smallest - errors.begin()) * (latest - earliest) / trials;
    constexpr double distinct = 100.0; // times the sum of squares, without the onset
    if (!(squared_error(travel, begin, nearly_all + 1, 1.0 / unit, travel.times.back()) >
          distinct * least))
        return std::nullopt;
    // The standard uncertainty is where the sum of squares has grown by one variance.
    const auto freedom = static_cast<double>(nearly_all + 1 - begin) - 5.0;
    const double limit = least * (1.0 + 1.0 / std::max(freedom, 1.0));
    const auto within = std::ranges::count_if(errors, [&](double error) { return error <= limit; });
    best.uncertainty = 0.5 * static_cast<double>(within) * (latest - earliest) / trials;
    return best;
}

} // namespace culm::measure
