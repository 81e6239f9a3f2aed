// SPDX-License-Identifier: BSD-3-Clause
// A decaying swing about an unknown rest position, as a recurrence between frames.
#pragma once

#include "measure/row_record.hpp"

#include <cstddef>
#include <optional>
#include <vector>

namespace culm::measure {

/// y(n+2L) − c = a (y(n+L) − c) + b (y(n) − c) for every damped sine, whatever its phase and
/// amplitude: a = 2 exp(−αL) cos ωL, b = −exp(−2αL). One a and b for all places, c per place.
struct SwingModel {
    int lag = 1; ///< L, frames
    double a = 0.0;
    double b = 0.0;
    std::vector<double> rest; ///< c, pixels; NaN where nothing was seen

    [[nodiscard]] double cycles_per_frame() const; ///< 0 if the recurrence does not swing
    [[nodiscard]] double decay_per_frame() const;  ///< α, ≥ 0
};

/// Linear least squares over the frames begin … end − 1 (indices), with a lag of about an eighth of
/// the period (in frames). Triples with a frame missing are left out. Empty if fewer than a dozen
/// are left or the recurrence determines no rest position.
[[nodiscard]] std::optional<SwingModel> fit_swing(const AxisRecord& record, std::size_t begin,
                                                  std::size_t end, double period);

/// What the recurrence leaves in one history: y(n+2L) less its prediction from y(n+L) and y(n), at
/// the index of n+2L; NaN where one of the frames is missing.
[[nodiscard]] std::vector<double> swing_surprises(const std::vector<int>& numbers,
                                                  const std::vector<double>& history,
                                                  const SwingModel& model, double rest);

} // namespace culm::measure
