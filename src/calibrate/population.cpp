// SPDX-License-Identifier: BSD-3-Clause
#include "calibrate/population.hpp"

#include <algorithm>
#include <functional>
#include <vector>

namespace culm::calibrate {

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
        return reduce::summarise(values);
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
