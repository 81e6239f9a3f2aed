// SPDX-License-Identifier: BSD-3-Clause
// What the camera does to the picture of the stem.
#pragma once

namespace culm::physics {

/// Errors of the camera, not of the stem. Zeros: a global shutter at a right angle.
struct CameraView {
    /// The row at the height of the stem's free length is read so much later than that at the
    /// clamp, s; negative if the other way round.
    double readout_time = 0.0;
    /// A deflection of the tip's row is read larger by this share, one at the clamp not at all.
    double scale_change = 0.0;

    friend bool operator==(const CameraView&, const CameraView&) = default;
};

} // namespace culm::physics
