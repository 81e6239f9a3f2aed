// SPDX-License-Identifier: BSD-3-Clause
// Refuses recordings in which nothing stands out of the noise.
#pragma once

#include "measure/folder/measurement.hpp"

#include <optional>

namespace culm::diagnose {

/// Throws core::InputError if the readings after the release, up to `window` seconds if given, are
/// what their noise alone would give: their χ² is less than five standard deviations √(2n) above
/// its mean n. A fit to them would wander without an end. Where no noise is known nothing is said.
void refuse_mere_noise(const measure::Measurement& measurement, std::optional<double> window);

} // namespace culm::diagnose
