// SPDX-License-Identifier: BSD-3-Clause
#include "measure/import/import_recording.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Core>

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

/// A straight line through the positions of frames [begin, end).
struct Drift {
    Drift(const Travel& travel, std::size_t begin, std::size_t end) {
        const auto count = static_cast<Eigen::Index>(end - begin);
        const Eigen::Map<const Eigen::ArrayXd> times(&travel.times[begin], count);
        const Eigen::Map<const Eigen::ArrayXd> positions(&travel.positions[begin], count);
        time = times.mean();
        position = positions.mean();
        const double square = (times - time).square().sum();
        rate = ((times - time) * positions).sum() / square;
        const double scatter = (positions - position - rate * (times - time)).square().sum();
        variance = scatter / static_cast<double>(count - 2);
        rate_variance = variance / square;
    }
    [[nodiscard]] double travelled(const Travel& travel, std::size_t frame) const {
        return travel.positions[frame] - position - rate * (travel.times[frame] - time);
    }
    /// Standard deviation of travelled() in a frame in which the stem is still held.
    [[nodiscard]] double deviation(const Travel& travel, std::size_t frame) const {
        return std::sqrt(variance + rate_variance * std::pow(travel.times[frame] - time, 2));
    }

    double time, position, rate, variance, rate_variance;
};

} // namespace

std::optional<ReleaseOnset> release_onset(std::span<const double> times,
                                          std::span<const double> positions) {
    constexpr double distinct = 4.0;    // standard deviations
    constexpr double frame_share = 0.5; // nearly the range of times between two frames
    constexpr double opening = 0.01;    // share of the swing by which a hand moves as it opens
    constexpr std::size_t fewest_held = 5;
    const Travel travel = travel_of(times, positions);
    const std::size_t half = first_at(travel, 0.5, 0);
    const std::size_t nearly_all = std::max(first_at(travel, 0.9, half), half + 1);
    if (half < fewest_held || nearly_all + 1 >= travel.times.size())
        return std::nullopt;
    // A rate sin ω(t − t₀) rises from half of its maximum to nine tenths while ω t grows by 0.6.
    const double unit = (travel.times[nearly_all] - travel.times[half]) / 0.6; // 1/ω
    const auto frame_at = [&](double units) {
        return static_cast<std::size_t>(
            std::ranges::lower_bound(travel.times, travel.times[half] - units * unit) -
            travel.times.begin());
    };
    const std::size_t end = std::max(std::min(frame_at(2.0), half), fewest_held);
    const Drift drift(travel, std::min(frame_at(8.0), end - fewest_held), end);
    double largest = 0.0;
    for (std::size_t i = 0; i < travel.times.size(); ++i)
        largest = std::max(largest, std::abs(travel.positions[i] - drift.position));
    std::size_t held = half;
    while (held > 0 && std::abs(drift.travelled(travel, held)) >
                           std::max(distinct * drift.deviation(travel, held), opening * largest))
        --held;
    if (held == 0 || held == half)
        return std::nullopt;
    // Under a sudden force the root of the travel is linear in time.
    const double first = std::sqrt(std::abs(drift.travelled(travel, held + 1)));
    const double second = std::sqrt(std::abs(drift.travelled(travel, held + 2)));
    const double rate = (second - first) / (travel.times[held + 2] - travel.times[held + 1]);
    ReleaseOnset onset{travel.times[held],
                       frame_share * (travel.times[held + 1] - travel.times[held])};
    if (rate > 0.0)
        onset.time = std::clamp(travel.times[held + 1] - first / rate, travel.times[held - 1],
                                travel.times[held + 1]);
    return onset;
}

} // namespace culm::measure
