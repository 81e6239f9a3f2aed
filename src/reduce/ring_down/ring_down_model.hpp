// SPDX-License-Identifier: BSD-3-Clause
// Eq. 1 of Schramm et al. (2019) with a phase and an offset, and the minimum of its sum of squares.
//
// With c = b0 cos φ and s = b0 sin φ,
//
//     y(t) = offset + e^(b1 t) (c cos 2π b2 t − s sin 2π b2 t)
//
// is linear in c, s and the offset. The minimum is found by Newton's method with the exact Hessian,
// which converges quadratically where Gauss-Newton slows down because of large residuals; where the
// Hessian is not positive definite or a step increases the sum, Levenberg-Marquardt takes over.
//
// Traps. The sum of squares has a minimum near every frequency of the history: a fit needs the
// starts of ring_down_starts(). Frequencies from half the sampling rate on have a lower alias with
// the same samples.
#pragma once

#include <numbers>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

namespace culm::reduce {

inline constexpr double two_pi = 2.0 * std::numbers::pi;

/// A normalised history; both of the same length. The caller chooses the unit of time.
struct RingDownSamples {
    std::vector<double> times;
    std::vector<double> values;
};

/// c, b1 (1/time), b2 (1/time), s and the offset.
struct RingDownParameters {
    double amplitude = 0.0; ///< c: b0 without a phase
    double decay_rate = 0.0;
    double frequency = 0.0;
    double quadrature = 0.0; ///< s
    double offset = 0.0;
};

/// Which parameters are fitted: b1 and b2 always.
struct FreeRingDownParameters {
    bool amplitude = true;
    bool quadrature = false;
    bool offset = false;

    [[nodiscard]] Eigen::Index count() const {
        return 2 + (amplitude ? 1 : 0) + (quadrature ? 1 : 0) + (offset ? 1 : 0);
    }
    /// Index of b1 among the free parameters; that of b2 follows. c is the first, then after b2 s
    /// and the offset.
    [[nodiscard]] Eigen::Index decay() const { return amplitude ? 1 : 0; }
};

/// e^(b1 t) cos(2π b2 t) and e^(b1 t) sin(2π b2 t). At equally spaced times two exponentials and
/// two sines serve 64 samples, by multiplication of complex numbers; the error is about 1e-15 of
/// the envelope. At other times every sample has its own.
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

/// The sum of squares of a history and its derivatives by the free parameters.
class RingDownProblem {
  public:
    RingDownProblem(const RingDownSamples& samples, const FreeRingDownParameters& free);

    /// Sets residuals (model − value) and sum_of_squares.
    void evaluate(const RingDownParameters& at);
    /// Sets jacobian, at the parameters that were evaluated.
    void evaluate_jacobian();
    /// ∂²(½ Σ r²)/∂p², after evaluate_jacobian.
    [[nodiscard]] Eigen::MatrixXd hessian() const;

    [[nodiscard]] const FreeRingDownParameters& free() const { return free_; }
    [[nodiscard]] const Eigen::VectorXd& residuals() const { return residuals_; } ///< (samples)
    [[nodiscard]] const Eigen::MatrixXd& jacobian() const { return jacobian_; } ///< (samples, free)
    [[nodiscard]] double sum_of_squares() const { return residuals_.squaredNorm(); }
    /// The parameters after a step of the free ones.
    [[nodiscard]] RingDownParameters moved(RingDownParameters at,
                                           const Eigen::VectorXd& step) const;

  private:
    FreeRingDownParameters free_;
    RingDownBasis basis_;
    Eigen::Map<const Eigen::VectorXd> values_;
    Eigen::ArrayXd motion_; ///< e^(b1 t) (c cos − s sin), and with sin for cos and cos for −sin
    Eigen::ArrayXd conjugate_;
    Eigen::VectorXd residuals_;
    Eigen::MatrixXd jacobian_;
};

/// A minimum of Σ (model − value)².
struct RingDownMinimum {
    RingDownParameters parameters; ///< frequency >= 0
    double sum_of_squares = 0.0;
};

/// The minimum that a start leads to, to about 1e-10 of the parameters; empty if there is none.
[[nodiscard]] std::optional<RingDownMinimum> minimum_from(RingDownProblem& problem,
                                                          const RingDownParameters& start);

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
