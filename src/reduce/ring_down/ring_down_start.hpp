// SPDX-License-Identifier: BSD-3-Clause
// Starts for the fit of Eq. 1: the best peaks of a scan over frequency and decay.
#pragma once

#include "reduce/ring_down/ring_down_model.hpp"

#include <vector>

namespace culm::reduce {

/// At most four starts for the fit of Eq. 1, best first, with frequencies up to half the sampling
/// rate; empty if no trial explains anything.
///
/// For given b1 and b2 the best b0 is a linear problem: the explained sum of squares is
/// (Σ y e cos)² / Σ (e cos)², e = exp(b1 t). One Fourier transform per decay rate, zero padded
/// fourfold, gives both sums at all frequencies, so the scan covers the plane without gaps:
/// steps of a quarter of 1/duration in b2 (phase error at the end of at most 45°) and factors of
/// two in b1 (overlap of neighbouring envelopes at least 0.98). Samples are sorted into bins of the
/// median interval, so gaps and jitter are allowed.
[[nodiscard]] std::vector<RingDownParameters> ring_down_starts(const RingDownSamples& samples,
                                                               double largest_decay_per_cycle);

} // namespace culm::reduce
