// SPDX-License-Identifier: BSD-3-Clause
// Steps along the curved valley of a constant frequency.
#pragma once

#include "fit/solve/residuals.hpp"

#include <cstddef>
#include <optional>
#include <vector>

#include <ceres/manifold.h>

namespace culm::fit {

/// A ring-down determines the stem's frequency to 1e-4, and many parameters change it: a mass at
/// the tip, a soft clamp, a taper. The valley in which Y compensates for them is narrow and curved,
/// and straight steps along it are a hundredth of its length. Here a step keeps its direction,
/// except that Y takes the value at which the linearised chain has the frequency of the straight
/// step to first order. Derivatives at the point are those of straight steps.
class ValleySteps : public ceres::Manifold {
  public:
    /// `residuals` must outlive this; `is_held` parameters do not move.
    ValleySteps(const JointResiduals& residuals, const JointLayout& layout,
                const std::vector<bool>& is_held);

    [[nodiscard]] int AmbientSize() const override { return static_cast<int>(size_); }
    [[nodiscard]] int TangentSize() const override { return static_cast<int>(free_.size()); }
    bool Plus(const double* point, const double* step, double* moved) const override;
    bool PlusJacobian(const double* point, double* jacobian) const override;
    /// Exact to first order.
    bool Minus(const double* moved, const double* point, double* step) const override;
    bool MinusJacobian(const double* point, double* jacobian) const override;

  private:
    /// ln f² of the first recording's chain.
    [[nodiscard]] double log_square(const std::vector<double>& internal) const;
    void follow_frequency(const std::vector<double>& point, std::vector<double>& moved) const;

    const JointResiduals& residuals_;
    std::size_t size_;
    std::vector<std::size_t> free_;
    std::optional<std::size_t> modulus_; ///< place of Y, whose internal value is its logarithm
};

} // namespace culm::fit
