// SPDX-License-Identifier: BSD-3-Clause
// Measurements whose stated inputs are wrong.
#pragma once

#include "fit/errors/stated_inputs.hpp"
#include "measure/folder/measurement.hpp"

#include <cstdint>
#include <random>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace culm::bench {

/// An independent random generator for each use.
[[nodiscard]] inline std::mt19937_64 dice_for(std::uint64_t seed, std::uint64_t number,
                                              std::string_view use) {
    std::vector<std::uint64_t> words{seed, number};
    words.insert(words.end(), use.begin(), use.end());
    std::seed_seq mixed(words.begin(), words.end());
    return std::mt19937_64(mixed);
}

/// By how many standard uncertainties an input is wrong. The error depends on the name, not
/// on the order: an input that recordings share has the same error in all of them.
[[nodiscard]] inline double normal_error(const std::string& input, std::uint64_t seed,
                                         std::uint64_t number) {
    std::mt19937_64 dice = dice_for(seed, number, input);
    return std::normal_distribution<double>()(dice);
}

/// The measurement with errors of ruler, calipers, balance and camera: each input has an error of
/// error_of(input) times the uncertainty that culm assumes for it. A known mass stays at the tip.
template <class ErrorOf>
[[nodiscard]] measure::Measurement misstated(measure::Measurement measurement, ErrorOf&& error_of) {
    for (const fit::StatedInput& input : fit::stated_inputs(measurement)) {
        const double error = input.standard_uncertainty * error_of(input);
        if (input.name == "length")
            measurement.stem.length += error;
        else if (input.name == "diameter")
            std::get<measure::CircularSection>(measurement.stem.section).diameter += error;
        else if (input.name == "density")
            measurement.stem.density += error;
        else if (input.name == "clamp height")
            for (double& height : measurement.heights)
                height += error;
        else if (input.name == "scale") {
            for (double& height : measurement.heights)
                height *= 1.0 + error;
            for (double& reading : measurement.deflections)
                reading *= 1.0 + error;
        } else if (input.name.starts_with("mass at"))
            measurement.stem.added_masses.front().mass += error;
    }
    for (measure::AddedMass& mass : measurement.stem.added_masses)
        mass.height = measurement.stem.length;
    return measurement;
}

} // namespace culm::bench
