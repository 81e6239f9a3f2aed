// SPDX-License-Identifier: BSD-3-Clause
// Readings over their noise, whitened by their noise model: residuals and columns of a weighted
// system have white noise of unit variance.
#pragma once

#include "fit/chain/observed_recording.hpp"

#include <memory>
#include <span>
#include <vector>

namespace culm::fit {

/// Divides readings by their noise and whitens them after their noise model: first the rows of a
/// frame, by the symmetric root of their covariance, then each row in time.
class ReadingWeights {
  public:
    /// `noise`: (rows), m. `is_seen`: (frames, rows). A null model: the readings are independent.
    ReadingWeights(std::vector<double> noise, std::shared_ptr<const NoiseModel> model,
                   std::vector<bool> is_seen);

    /// Weighs (frames, rows) of readings, or any quantity linear in these, in place. Readings that
    /// were not seen and values that are not finite become 0.
    void apply(std::span<double> values) const;

  private:
    void separate_rows(std::span<double> values) const;
    void separate_frames(std::span<double> values) const;

    std::vector<double> noise_;
    std::shared_ptr<const NoiseModel> model_;
    std::vector<bool> is_seen_;
};

} // namespace culm::fit
