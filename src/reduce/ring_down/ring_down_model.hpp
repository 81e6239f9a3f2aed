// SPDX-License-Identifier: BSD-3-Clause
// Eq. 1 of Schramm et al. (2019), y(t) = b0 exp(b1 t) cos(2π b2 t), its derivatives, and the exact
// minimum of its sum of squares.
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

/// b0, b1 (1/time), b2 (1/time).
struct RingDownParameters {
    double amplitude = 0.0;
    double decay_rate = 0.0;
    double frequency = 0.0;
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

/// Eq. 1 at all samples, and its gradient.
class RingDownLinearisation {
  public:
    explicit RingDownLinearisation(const RingDownSamples& samples)
        : basis_(samples.times),
          values_(Eigen::Map<const Eigen::ArrayXd>(samples.values.data(), basis_.times().size())),
          jacobian_(basis_.times().size(), 3) {}

    void evaluate_residuals(const RingDownParameters& at) {
        basis_.evaluate(at.decay_rate, at.frequency);
        residuals_ = at.amplitude * basis_.in_phase() - values_;
    }
    /// To be called after evaluate_residuals with the same parameters.
    void evaluate_jacobian(const RingDownParameters& at) {
        jacobian_.col(0) = basis_.in_phase();
        jacobian_.col(1) = at.amplitude * basis_.times() * basis_.in_phase();
        jacobian_.col(2) = -two_pi * at.amplitude * basis_.times() * basis_.quadrature();
    }

    [[nodiscard]] const RingDownBasis& basis() const { return basis_; }
    [[nodiscard]] const Eigen::ArrayXd& residuals() const { return residuals_; }
    /// (samples, 3): by b0, b1, b2.
    [[nodiscard]] const Eigen::Matrix<double, Eigen::Dynamic, 3>& jacobian() const {
        return jacobian_;
    }

    /// JᵀJ; by single products, which for three columns are cheaper than a blocked one.
    [[nodiscard]] Eigen::Matrix3d gram_matrix() const {
        Eigen::Matrix3d gram;
        for (Eigen::Index i = 0; i < 3; ++i)
            for (Eigen::Index j = 0; j <= i; ++j)
                gram(i, j) = gram(j, i) = jacobian_.col(i).dot(jacobian_.col(j));
        return gram;
    }

  private:
    RingDownBasis basis_;
    Eigen::ArrayXd values_;
    Eigen::ArrayXd residuals_;
    Eigen::Matrix<double, Eigen::Dynamic, 3> jacobian_;
};

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

/// First and second derivatives of half the sum of squares.
struct RingDownCurvature {
    double residual_sum_of_squares = 0.0;
    Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
    Eigen::Matrix3d gauss_newton = Eigen::Matrix3d::Zero();
    Eigen::Matrix3d newton = Eigen::Matrix3d::Zero();
};

/// Derivatives for a minimiser: the first equation of gradient and matrices is "step of b0 = 0"
/// unless amplitude_is_free.
[[nodiscard]] RingDownCurvature curvature(RingDownLinearisation& model,
                                          const RingDownParameters& at, bool amplitude_is_free);

/// A minimum of Σ (model − value)².
struct RefinedRingDown {
    RingDownParameters parameters; ///< frequency >= 0
    double residual_sum_of_squares = 0.0;
    int iterations = 0;
};

/// Levenberg-Marquardt (normal equations, analytic Jacobian) from a start; empty if it fails. The
/// frequency of the start must not be 0: its period is the unit of time. The amplitude of the start
/// stays as it is unless amplitude_is_free.
[[nodiscard]] std::optional<RefinedRingDown> refine_ring_down(const RingDownSamples& samples,
                                                              const RingDownParameters& start,
                                                              bool amplitude_is_free);

/// Newton's method with the exact Hessian, which converges quadratically where Levenberg-Marquardt
/// slows down because of large residuals. True if the last step was below 1e-10
/// relative (of the decay: or 1e-13 per cycle).
[[nodiscard]] bool polish_ring_down(const RingDownSamples& samples, bool amplitude_is_free,
                                    RefinedRingDown& refined);

/// Covariance of (b0, b1, b2), σ² (JᵀJ)⁻¹ with σ² = RSS/(N − free parameters); rows and columns of
/// a fixed b0 are 0. Empty if the Jacobian is rank deficient.
[[nodiscard]] std::optional<Eigen::Matrix3d> ring_down_covariance(const RingDownSamples& samples,
                                                                  bool amplitude_is_free,
                                                                  const RefinedRingDown& refined);

} // namespace culm::reduce
