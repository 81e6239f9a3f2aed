// SPDX-License-Identifier: BSD-3-Clause
#include "calibrate/population.hpp"

#include <algorithm>
#include <cstdint>
#include <functional>
#include <random>
#include <utility>
#include <vector>

namespace culm::calibrate {
namespace {

/// A whole number below `count`, the same on every standard library (a bias of count/2⁶⁴).
std::size_t draw_below(std::mt19937_64& generator, std::size_t count) {
    __extension__ using Wide = unsigned __int128;
    return static_cast<std::size_t>((static_cast<Wide>(generator()) * count) >> 64U);
}

reduce::Bounds central_95_percent(std::vector<double> values) {
    std::ranges::sort(values);
    return {reduce::quantile(values, 0.025), reduce::quantile(values, 0.975)};
}

} // namespace

CentralRange central_range(std::span<const double> values, int resamples) {
    CentralRange result;
    result.sample = reduce::summarise(values);
    result.lower_interval = result.upper_interval = result.sample.central_90_percent;
    if (values.size() < 2)
        return result;
    constexpr std::uint64_t seed = 2019; // arbitrary
    std::mt19937_64 generator(seed);
    std::vector<double> lower;
    std::vector<double> upper;
    std::vector<double> drawn(values.size());
    for (int k = 0; k < resamples; ++k) {
        for (double& value : drawn)
            value = values[draw_below(generator, values.size())];
        std::ranges::sort(drawn);
        lower.push_back(reduce::quantile(drawn, 0.05));
        upper.push_back(reduce::quantile(drawn, 0.95));
    }
    result.lower_interval = central_95_percent(std::move(lower));
    result.upper_interval = central_95_percent(std::move(upper));
    return result;
}

StemNumbers numbers_of(const Calibration& calibration) {
    return {calibration.part().find(physics::bond_youngs_modulus)->value,
            calibration.part().find(physics::bond_damping)->value, calibration.mode.decay_per_cycle,
            calibration.mode.frequency, calibration.verdict.finding == diagnose::Finding::Adequate};
}

std::optional<Population> population_of(std::span<const StemNumbers> calibrated,
                                        std::size_t failed) {
    if (calibrated.size() < 2)
        return std::nullopt;
    const auto range = [calibrated](double StemNumbers::*quantity) {
        std::vector<double> values;
        values.reserve(calibrated.size());
        for (const StemNumbers& stem : calibrated)
            values.push_back(stem.*quantity);
        return central_range(values);
    };
    const auto inadequate =
        std::ranges::count_if(calibrated, std::not_fn(&StemNumbers::is_adequate));
    return Population{calibrated.size(),
                      failed,
                      static_cast<std::size_t>(inadequate),
                      range(&StemNumbers::bond_youngs_modulus),
                      range(&StemNumbers::bond_damping),
                      range(&StemNumbers::decay_per_cycle),
                      range(&StemNumbers::frequency)};
}

} // namespace culm::calibrate
