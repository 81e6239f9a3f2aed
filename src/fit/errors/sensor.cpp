// SPDX-License-Identifier: BSD-3-Clause
#include "fit/errors/terms.hpp"

#include <algorithm>
#include <cstddef>
#include <tuple>

#include <fmt/core.h>

namespace culm::fit {
namespace {

constexpr double drift_share = 0.1; ///< of the rms reading, over the record

} // namespace

std::vector<ErrorTerm> sensor_terms(const measure::Measurement& measurement) {
    std::vector<ErrorTerm> terms;
    const std::vector<double>& times = measurement.times;
    const double middle = 0.5 * (times.front() + times.back());
    const double duration = std::max(times.back() - times.front(), 1e-12);
    const std::size_t rows = measurement.heights.size();
    for (std::size_t j = 0; j < measurement.sensors.size(); ++j) {
        const measure::Sensor& sensor = measurement.sensors[j];
        if (sensor.is_camera())
            continue;
        const double usual = measurement.rms_reading(j);
        const double offset = sensor.offset_uncertainty.value_or(usual);
        const double drift = sensor.drift_uncertainty.value_or(drift_share * usual / duration);
        for (const auto& [kind, constant, rate] :
             {std::tuple("offset", offset, 0.0), std::tuple("drift", 0.0, drift)}) {
            if (constant == 0.0 && rate == 0.0)
                continue;
            ErrorTerm& term = terms.emplace_back();
            term.kind = ErrorKind::Sensor;
            term.id = fmt::format("{} of {} of {}", kind, sensor.column, measurement.stem.id);
            term.readings.assign(times.size() * rows, 0.0);
            for (std::size_t i = 0; i < times.size(); ++i)
                term.readings[i * rows + j] = constant + rate * (times[i] - middle);
        }
    }
    return terms;
}

} // namespace culm::fit
