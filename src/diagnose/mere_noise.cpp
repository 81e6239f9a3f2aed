// SPDX-License-Identifier: BSD-3-Clause
#include "diagnose/mere_noise.hpp"

#include "core/error.hpp"

#include <cmath>
#include <limits>

#include <fmt/core.h>

namespace culm::diagnose {
namespace {

constexpr double needed_excess = 5.0; ///< standard deviations of χ²

} // namespace

void refuse_mere_noise(const measure::Measurement& measurement, std::optional<double> window) {
    const double end = window.value_or(std::numeric_limits<double>::infinity());
    double chi_squared = 0.0;
    double squares = 0.0;
    double noise_squares = 0.0;
    double readings = 0.0;
    for (std::size_t i = 0; i < measurement.times.size(); ++i)
        for (std::size_t j = 0; j < measurement.heights.size(); ++j) {
            const double reading = measurement.deflection(i, j);
            const std::optional<double> noise = measurement.noise_at(j);
            if (measurement.times[i] < 0.0 || measurement.times[i] > end || std::isnan(reading) ||
                !noise)
                continue;
            chi_squared += std::pow(reading / *noise, 2);
            squares += reading * reading;
            noise_squares += *noise * *noise;
            readings += 1.0;
        }
    if (readings > 0.0 && chi_squared - readings < needed_excess * std::sqrt(2.0 * readings))
        throw core::InputError(fmt::format(
            "{}: the readings after the release (rms {:.3g} mm) cannot be told from their noise "
            "({:.3g} mm): there is no motion to compare with",
            measurement.stem.id, 1e3 * std::sqrt(squares / readings),
            1e3 * std::sqrt(noise_squares / readings)));
}

} // namespace culm::diagnose
