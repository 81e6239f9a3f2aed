// SPDX-License-Identifier: BSD-3-Clause
// The coordinates in the unit cube from which a study's factors take their values.
#pragma once

#include "study/config.hpp"

#include <cstdint>
#include <string>
#include <vector>

namespace culm::study {

/// One coordinate of the unit cube; factors whose rows stay together share one.
struct UnitSample {
    std::string name;
    bool is_redrawn = false;
    std::int64_t draws = 1; ///< for each design point: one, one for each stem, or for each test
    std::vector<double> u;  ///< (design points, draws), in (0, 1)
};

struct UnitSamples {
    std::vector<UnitSample> samples;
    /// For each factor its sample; none where its levels are taken one by one.
    std::vector<std::size_t> sample_of_factor;
    static constexpr std::size_t none = static_cast<std::size_t>(-1);
};

/// The samples of a study with so many design points, correlated as it says. A function of the
/// study alone (design.hpp says which).
[[nodiscard]] UnitSamples draw_unit_samples(const StudyConfig& config, std::int64_t design_points);

} // namespace culm::study
