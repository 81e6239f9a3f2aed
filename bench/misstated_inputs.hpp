// SPDX-License-Identifier: BSD-3-Clause
// Measurements whose stated inputs are wrong.
#pragma once

#include "fit/solve/reading_errors.hpp"
#include "measure/folder/measurement.hpp"

#include <utility>
#include <variant>

namespace culm::bench {

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
