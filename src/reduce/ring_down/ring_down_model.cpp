// SPDX-License-Identifier: BSD-3-Clause
#include "reduce/ring_down/ring_down_model.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <ceres/tiny_solver.h>

namespace culm::reduce {

namespace {

constexpr Eigen::Index phasor_block = 64; // samples that share one pair of exponential and sine

/// The interval of equally spaced times; 0 if one deviates by more than the rounding of the times.
double equal_interval(const Eigen::ArrayXd& times) {
    const Eigen::Index samples = times.size();
    if (samples < 2 * phasor_block)
        return 0.0;
    const double interval = (times[samples - 1] - times[0]) / static_cast<double>(samples - 1);
    const double largest = std::max(std::abs(times[0]), std::abs(times[samples - 1]));
    const double rounding = 4.0 * std::numeric_limits<double>::epsilon() * largest;
    for (Eigen::Index i = 0; i < samples; ++i)
        if (std::abs(times[0] + static_cast<double>(i) * interval - times[i]) > rounding)
            return 0.0;
    return interval;
}

/// A fixed amplitude: its equation becomes "step = 0".
void fix_amplitude(Eigen::Vector3d& gradient, Eigen::Matrix3d& matrix) {
    gradient[0] = 0.0;
    matrix.row(0).setZero();
    matrix.col(0).setZero();
    matrix(0, 0) = 1.0;
}

/// The Newton step, or the Gauss-Newton step where the Hessian is not positive definite.
Eigen::Vector3d minimising_step(const RingDownCurvature& at) {
    const Eigen::Vector3d scale = at.gauss_newton.diagonal().cwiseSqrt().cwiseInverse();
    const auto scaled_step = [&](const Eigen::Matrix3d& matrix, bool& is_definite) {
        const Eigen::LLT<Eigen::Matrix3d> factor(scale.asDiagonal() * matrix * scale.asDiagonal());
        is_definite = factor.info() == Eigen::Success;
        const Eigen::Vector3d step = -factor.solve(scale.cwiseProduct(at.gradient));
        return Eigen::Vector3d(scale.cwiseProduct(step));
    };
    bool is_definite = false;
    Eigen::Vector3d step = scaled_step(at.newton, is_definite);
    if (!is_definite)
        step = scaled_step(at.gauss_newton, is_definite);
    return step;
}

/// Largest step relative to its parameter; the decay's scale does not fall below 1e-3 per cycle,
/// because an undamped motion has a decay of zero.
double relative_size(const Eigen::Vector3d& step, const RingDownParameters& at) {
    const double decay_scale = std::max(std::abs(at.decay_rate), 1e-3 * at.frequency);
    return std::max({std::abs(step[0] / at.amplitude), std::abs(step[1]) / decay_scale,
                     std::abs(step[2] / at.frequency)});
}

/// Residuals of Eq. 1 by b0 and by b1 and b2 per period of the start; all three are of order one.
class ScaledResiduals {
  public:
    using Scalar = double;
    static constexpr int NUM_RESIDUALS = Eigen::Dynamic;
    static constexpr int NUM_PARAMETERS = 3;

    ScaledResiduals(const RingDownSamples& samples, double rate, bool amplitude_is_free)
        : model_(samples), rate_(rate), amplitude_is_free_(amplitude_is_free) {}

    [[nodiscard]] RingDownParameters parameters(const double* x) const {
        return {x[0], x[1] * rate_, x[2] * rate_};
    }
    [[nodiscard]] int NumResiduals() const {
        return static_cast<int>(model_.basis().times().size());
    }
    /// The interface of ceres::TinySolver; a fixed amplitude has no derivative.
    bool operator()(const double* x, double* residuals, double* jacobian) const {
        const RingDownParameters at = parameters(x);
        model_.evaluate_residuals(at);
        Eigen::Map<Eigen::ArrayXd>(residuals, NumResiduals()) = model_.residuals();
        if (jacobian != nullptr) {
            model_.evaluate_jacobian(at);
            Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, 3>>(jacobian, NumResiduals(), 3) =
                model_.jacobian() *
                Eigen::Vector3d(amplitude_is_free_ ? 1.0 : 0.0, rate_, rate_).asDiagonal();
        }
        return true;
    }

  private:
    mutable RingDownLinearisation model_;
    double rate_;
    bool amplitude_is_free_;
};

} // namespace

RingDownBasis::RingDownBasis(std::span<const double> times)
    : times_(
          Eigen::Map<const Eigen::ArrayXd>(times.data(), static_cast<Eigen::Index>(times.size()))),
      interval_(equal_interval(times_)), in_phase_(times_.size()), quadrature_(times_.size()) {}

void RingDownBasis::evaluate(double decay_rate, double frequency) {
    const double angular_frequency = 2.0 * std::numbers::pi * frequency;
    if (interval_ > 0.0) {
        evaluate_blockwise(decay_rate, angular_frequency);
        return;
    }
    for (Eigen::Index i = 0; i < times_.size(); ++i) {
        const double envelope = std::exp(decay_rate * times_[i]);
        const double phase = angular_frequency * times_[i];
        in_phase_[i] = envelope * std::cos(phase);
        quadrature_[i] = envelope * std::sin(phase);
    }
}

void RingDownBasis::evaluate_blockwise(double decay_rate, double angular_frequency) {
    const Eigen::Index samples = times_.size();
    // Within the first block, relative to its first sample.
    Eigen::Array<double, phasor_block, 1> cosine;
    Eigen::Array<double, phasor_block, 1> sine;
    for (Eigen::Index j = 0; j < phasor_block; ++j) {
        const double time = static_cast<double>(j) * interval_;
        const double envelope = std::exp(decay_rate * time);
        cosine[j] = envelope * std::cos(angular_frequency * time);
        sine[j] = envelope * std::sin(angular_frequency * time);
    }
    for (Eigen::Index first = 0; first < samples; first += phasor_block) {
        const Eigen::Index count = std::min(phasor_block, samples - first);
        const double envelope = std::exp(decay_rate * times_[first]);
        const double c = envelope * std::cos(angular_frequency * times_[first]);
        const double s = envelope * std::sin(angular_frequency * times_[first]);
        in_phase_.segment(first, count) = c * cosine.head(count) - s * sine.head(count);
        quadrature_.segment(first, count) = s * cosine.head(count) + c * sine.head(count);
    }
}

RingDownCurvature curvature(RingDownLinearisation& model, const RingDownParameters& at,
                            bool amplitude_is_free) {
    model.evaluate_residuals(at);
    model.evaluate_jacobian(at);
    const Eigen::ArrayXd& residuals = model.residuals();
    const Eigen::ArrayXd& times = model.basis().times();
    RingDownCurvature sum;
    sum.residual_sum_of_squares = residuals.square().sum();
    sum.gradient = model.jacobian().transpose() * residuals.matrix();
    sum.gauss_newton = model.gram_matrix();
    // The Hessian of ½ Σ r² is JᵀJ + Σ r ∂²y/∂p_i ∂p_j, and with c = e^(b1 t) cos(2π b2 t) and
    // s = e^(b1 t) sin(2π b2 t) the second derivatives of y = b0 c by (b0, b1, b2) are
    //   0      t c      −2π t s
    //   t c    b0 t² c  −2π b0 t² s
    //   −2π t s  −2π b0 t² s  −(2π)² b0 t² c.
    const double in_phase = (residuals * times * model.basis().in_phase()).sum();
    const double quadrature = (residuals * times * model.basis().quadrature()).sum();
    const double square_in_phase = (residuals * times.square() * model.basis().in_phase()).sum();
    const double square_quadrature =
        (residuals * times.square() * model.basis().quadrature()).sum();
    Eigen::Matrix3d second;
    second(0, 0) = 0.0;
    second(0, 1) = second(1, 0) = in_phase;
    second(0, 2) = second(2, 0) = -two_pi * quadrature;
    second(1, 1) = at.amplitude * square_in_phase;
    second(1, 2) = second(2, 1) = -two_pi * at.amplitude * square_quadrature;
    second(2, 2) = -two_pi * two_pi * at.amplitude * square_in_phase;
    sum.newton = sum.gauss_newton + second;
    if (!amplitude_is_free) {
        fix_amplitude(sum.gradient, sum.gauss_newton);
        fix_amplitude(sum.gradient, sum.newton);
    }
    return sum;
}

std::optional<RefinedRingDown> refine_ring_down(const RingDownSamples& samples,
                                                const RingDownParameters& start,
                                                bool amplitude_is_free) {
    const ScaledResiduals residuals(samples, start.frequency, amplitude_is_free);
    ceres::TinySolver<ScaledResiduals> solver;
    solver.options.max_num_iterations = 200;
    // Rounding level; polish_ring_down refines the last digits.
    solver.options.gradient_tolerance = solver.options.function_tolerance = 1e-14;
    solver.options.parameter_tolerance = 1e-12;
    solver.options.cost_threshold = 0.0;
    Eigen::Vector3d x(start.amplitude, start.decay_rate / start.frequency, 1.0);
    solver.Solve(residuals, &x);
    if (!std::isfinite(solver.summary.final_cost))
        return std::nullopt;
    RefinedRingDown refined;
    refined.parameters = residuals.parameters(x.data());
    refined.parameters.frequency = std::abs(refined.parameters.frequency);
    refined.residual_sum_of_squares = 2.0 * solver.summary.final_cost;
    refined.iterations = solver.summary.iterations;
    return refined;
}

bool polish_ring_down(const RingDownSamples& samples, bool amplitude_is_free,
                      RefinedRingDown& refined) {
    constexpr int most_iterations = 12;
    constexpr double rounding = 1e-14;
    double previous = std::numeric_limits<double>::infinity();
    RingDownLinearisation model(samples);
    for (int iteration = 0; iteration < most_iterations; ++iteration) {
        RingDownParameters& at = refined.parameters;
        const RingDownCurvature here = curvature(model, at, amplitude_is_free);
        refined.residual_sum_of_squares = here.residual_sum_of_squares;
        const Eigen::Vector3d step = minimising_step(here);
        const double size = relative_size(step, at);
        // Small steps that no longer shrink consist of rounding.
        if (!(size > rounding) || (size < 1e-10 && size > 0.1 * previous))
            return std::isfinite(size);
        at = {at.amplitude + step[0], at.decay_rate + step[1], at.frequency + step[2]};
        previous = size;
        ++refined.iterations;
    }
    return previous < 1e-10;
}

std::optional<Eigen::Matrix3d> ring_down_covariance(const RingDownSamples& samples,
                                                    bool amplitude_is_free,
                                                    const RefinedRingDown& refined) {
    const int first = amplitude_is_free ? 0 : 1;
    const int free = 3 - first;
    const auto rows = static_cast<Eigen::Index>(samples.times.size());
    RingDownLinearisation model(samples);
    model.evaluate_residuals(refined.parameters);
    model.evaluate_jacobian(refined.parameters);
    const Eigen::MatrixXd jacobian = model.jacobian().rightCols(free);
    const Eigen::VectorXd scale = jacobian.colwise().norm();
    if (!(scale.minCoeff() > 0.0))
        return std::nullopt;
    const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(jacobian *
                                                         scale.cwiseInverse().asDiagonal());
    if (qr.rank() < free)
        return std::nullopt;
    Eigen::MatrixXd root = Eigen::MatrixXd::Identity(free, free);
    qr.matrixR().topLeftCorner(free, free).triangularView<Eigen::Upper>().solveInPlace(root);
    root = scale.cwiseInverse().asDiagonal() * (qr.colsPermutation() * root);
    const double variance = refined.residual_sum_of_squares / static_cast<double>(rows - free);
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
    covariance.bottomRightCorner(free, free) = variance * root * root.transpose();
    return covariance;
}

} // namespace culm::reduce
