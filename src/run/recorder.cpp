// SPDX-License-Identifier: BSD-3-Clause
#include "run/recorder.hpp"

#include "measure/camera_rows.hpp"

#include <algorithm>

namespace culm::run {

Recorder::Recorder(const CaseSpec& spec)
    : spec_(spec),
      first_watched_(spec.store >= StoreLevel::Heights ? 0 : spec.stem.sphere_count - 1) {
    const std::size_t samples = spec.sample_count();
    result_.tip_deflection.resize(samples);
    if (spec.store >= StoreLevel::Heights)
        result_.height_deflection.resize(samples * spec.heights.size());
    if (spec.store == StoreLevel::Full)
        result_.positions.assign(samples * static_cast<std::size_t>(spec.stem.sphere_count) * 3,
                                 0.0);
}

void Recorder::record(std::size_t index, std::span<const double> positions) {
    const auto dimensions = static_cast<std::size_t>(spec_.dimensions);
    result_.tip_deflection[index] = positions[positions.size() - dimensions + 1];
    if (spec_.store >= StoreLevel::Heights && !spec_.heights.empty()) {
        const std::vector<double> rows =
            measure::deflections_in_rows(positions, spec_.dimensions, spec_.heights);
        std::copy(rows.begin(), rows.end(),
                  result_.height_deflection.begin() +
                      static_cast<std::ptrdiff_t>(index * rows.size()));
    }
    if (spec_.store == StoreLevel::Full) {
        const auto spheres = static_cast<std::size_t>(spec_.stem.sphere_count);
        double* frame = result_.positions.data() + index * spheres * 3;
        for (std::size_t i = 0; i < spheres; ++i)
            std::copy_n(positions.data() + i * dimensions, dimensions, frame + 3 * i);
    }
}

} // namespace culm::run
