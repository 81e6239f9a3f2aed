// SPDX-License-Identifier: BSD-3-Clause
// A camera that reads its rows one after the other.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace culm::run {

/// Samples beyond the end of a history that a shutter with this readout time needs.
[[nodiscard]] std::size_t late_samples(double readout_time, double sample_interval);

/// Replaces each row of `history` ((samples)(heights), `interval` seconds apart, the first at the
/// release) by what it shows `delay_per_height` × height seconds later, by cubic interpolation.
/// Before the release the stem rests. The last samples, for which nothing later was recorded,
/// repeat the last one.
void read_late(std::vector<double>& history, std::span<const double> heights,
               double delay_per_height, double interval);

} // namespace culm::run
