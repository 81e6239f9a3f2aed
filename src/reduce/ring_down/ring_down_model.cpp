// SPDX-License-Identifier: BSD-3-Clause
#include "reduce/ring_down/ring_down_model.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <Eigen/Cholesky>

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

/// The larger of the damped Newton step and, where the Hessian is not positive definite, the damped
/// Gauss-Newton step; in units in which JᵀJ has ones on its diagonal.
Eigen::VectorXd minimising_step(const RingDownProblem& problem, const Eigen::MatrixXd& hessian,
                                double damping) {
    const Eigen::MatrixXd& jacobian = problem.jacobian();
    const Eigen::VectorXd scale = jacobian.colwise().norm().cwiseInverse();
    const Eigen::VectorXd gradient = jacobian.transpose() * problem.residuals();
    const auto scaled = [&](Eigen::MatrixXd matrix) {
        matrix = scale.asDiagonal() * matrix * scale.asDiagonal();
        matrix.diagonal().array() += damping;
        return Eigen::LLT<Eigen::MatrixXd>(matrix);
    };
    Eigen::LLT<Eigen::MatrixXd> factor = scaled(hessian);
    if (factor.info() != Eigen::Success)
        factor = scaled(jacobian.transpose() * jacobian);
    return -scale.cwiseProduct(factor.solve(scale.cwiseProduct(gradient)));
}

/// Largest step relative to its parameter; the decay's scale does not fall below 1e-3 per cycle,
/// because an undamped motion has a decay of zero. Phase and offset refer to the amplitude.
double relative_size(const Eigen::VectorXd& step, const FreeRingDownParameters& free,
                     const RingDownParameters& at) {
    const double amplitude = std::hypot(at.amplitude, at.quadrature);
    const double decay_scale = std::max(std::abs(at.decay_rate), 1e-3 * at.frequency);
    double size = std::max(std::abs(step[free.decay()]) / decay_scale,
                           std::abs(step[free.decay() + 1] / at.frequency));
    for (Eigen::Index k = 0; k < step.size(); ++k)
        if (k < free.decay() || k > free.decay() + 1)
            size = std::max(size, std::abs(step[k]) / amplitude);
    return size;
}

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

RingDownProblem::RingDownProblem(const RingDownSamples& samples, const FreeRingDownParameters& free)
    : free_(free), basis_(samples.times),
      values_(samples.values.data(), static_cast<Eigen::Index>(samples.values.size())),
      jacobian_(values_.size(), free.count()) {}

void RingDownProblem::evaluate(const RingDownParameters& at) {
    basis_.evaluate(at.decay_rate, at.frequency);
    motion_ = at.amplitude * basis_.in_phase() - at.quadrature * basis_.quadrature();
    conjugate_ = at.amplitude * basis_.quadrature() + at.quadrature * basis_.in_phase();
    residuals_ = (motion_ + at.offset).matrix() - values_;
}

void RingDownProblem::evaluate_jacobian() {
    Eigen::Index column = 0;
    if (free_.amplitude)
        jacobian_.col(column++) = basis_.in_phase();
    jacobian_.col(column++) = basis_.times() * motion_;
    jacobian_.col(column++) = -two_pi * basis_.times() * conjugate_;
    if (free_.quadrature)
        jacobian_.col(column++) = -basis_.quadrature();
    if (free_.offset)
        jacobian_.col(column).setOnes();
}

Eigen::MatrixXd RingDownProblem::hessian() const {
    // JᵀJ + Σ r ∂²y/∂p_i ∂p_j. With C = e^(b1 t) cos 2π b2 t, S likewise, m = c C − s S and
    // q = c S + s C, the second derivatives of y that are not 0 are
    //   (b1, b1) t² m   (b1, b2) −2π t² q   (b2, b2) −(2π)² t² m
    //   (c, b1) t C     (c, b2) −2π t S     (s, b1) −t S     (s, b2) −2π t C.
    Eigen::MatrixXd hessian = jacobian_.transpose() * jacobian_;
    const Eigen::ArrayXd weighted = residuals_.array() * basis_.times();
    const Eigen::ArrayXd squares = weighted * basis_.times();
    const double in_phase = (weighted * basis_.in_phase()).sum();
    const double quadrature = (weighted * basis_.quadrature()).sum();
    const double motion = (squares * motion_).sum();
    const double conjugate = (squares * conjugate_).sum();
    const Eigen::Index b1 = free_.decay();
    const Eigen::Index b2 = b1 + 1;
    const auto add = [&hessian](Eigen::Index i, Eigen::Index j, double value) {
        hessian(i, j) += value;
        if (i != j)
            hessian(j, i) += value;
    };
    add(b1, b1, motion);
    add(b1, b2, -two_pi * conjugate);
    add(b2, b2, -two_pi * two_pi * motion);
    if (free_.amplitude) {
        add(0, b1, in_phase);
        add(0, b2, -two_pi * quadrature);
    }
    if (free_.quadrature) {
        add(b2 + 1, b1, -quadrature);
        add(b2 + 1, b2, -two_pi * in_phase);
    }
    return hessian;
}

RingDownParameters RingDownProblem::moved(RingDownParameters at,
                                          const Eigen::VectorXd& step) const {
    Eigen::Index k = 0;
    if (free_.amplitude)
        at.amplitude += step[k++];
    at.decay_rate += step[k++];
    at.frequency += step[k++];
    if (free_.quadrature)
        at.quadrature += step[k++];
    if (free_.offset)
        at.offset += step[k];
    return at;
}

std::optional<RingDownMinimum> minimum_from(RingDownProblem& problem,
                                            const RingDownParameters& start) {
    constexpr int most_iterations = 200;
    constexpr double rounding = 1e-14;
    constexpr double converged = 1e-10;
    constexpr double most_damping = 1e10;
    RingDownMinimum found{start, 0.0};
    double damping = 1e-3;
    double previous = std::numeric_limits<double>::infinity();
    for (int iteration = 0; iteration < most_iterations; ++iteration) {
        problem.evaluate(found.parameters);
        problem.evaluate_jacobian();
        found.sum_of_squares = problem.sum_of_squares();
        const Eigen::MatrixXd hessian = problem.hessian();
        RingDownParameters next;
        double size = 0.0;
        for (;; damping = std::max(10.0 * damping, 1e-6)) {
            const Eigen::VectorXd step = minimising_step(problem, hessian, damping);
            size = relative_size(step, problem.free(), found.parameters);
            // Small steps that no longer shrink consist of rounding.
            if (!(size > rounding) || (size < converged && size > 0.1 * previous) ||
                damping > most_damping) {
                return std::isfinite(size) && size < converged ? std::optional(found)
                                                               : std::nullopt;
            }
            next = problem.moved(found.parameters, step);
            problem.evaluate(next);
            if (problem.sum_of_squares() <= found.sum_of_squares * (1.0 + rounding))
                break;
            problem.evaluate(found.parameters); // as the Jacobian is
        }
        found.parameters = next;
        if (next.frequency < 0.0) { // the same motion
            found.parameters.frequency = -next.frequency;
            found.parameters.quadrature = -next.quadrature;
        }
        previous = size;
        damping = damping < 1e-6 ? 0.0 : 0.1 * damping;
    }
    return std::nullopt;
}

} // namespace culm::reduce
