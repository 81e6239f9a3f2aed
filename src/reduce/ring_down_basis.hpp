// SPDX-License-Identifier: BSD-3-Clause
// The two oscillations that Eq. 1 and all its derivatives are made of, at all times of a history.
#pragma once

#include <cstddef>
#include <span>

#include <Eigen/Core>

namespace culm::reduce {

/// e^(b1 t) cos(2π b2 t) and e^(b1 t) sin(2π b2 t). At equally spaced times two exponentials and
/// two sines do for 64 samples, by multiplication of complex numbers; the error stays at some 1e-15
/// of the envelope. At other times every sample has its own.
class RingDownBasis {
  public:
    explicit RingDownBasis(std::span<const double> times);

    /// Sets in_phase and quadrature for a decay rate b1 and a frequency b2 (both 1/time).
    void evaluate(double decay_rate, double frequency);

    [[nodiscard]] const Eigen::ArrayXd& times() const { return times_; }           ///< (samples)
    [[nodiscard]] const Eigen::ArrayXd& in_phase() const { return in_phase_; }     ///< (samples)
    [[nodiscard]] const Eigen::ArrayXd& quadrature() const { return quadrature_; } ///< (samples)

  private:
    void evaluate_blockwise(double decay_rate, double angular_frequency);

    Eigen::ArrayXd times_;
    double interval_ = 0.0; ///< between neighbours; 0 unless all intervals are equal
    Eigen::ArrayXd in_phase_;
    Eigen::ArrayXd quadrature_;
};

} // namespace culm::reduce
