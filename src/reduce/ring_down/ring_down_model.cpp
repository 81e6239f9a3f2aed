// SPDX-License-Identifier: BSD-3-Clause
#include "reduce/ring_down/ring_down_model.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

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

/// The problem as Ceres' small solver calls it.
struct SmallProblem {
    using Scalar = double;
    enum { NUM_RESIDUALS = Eigen::Dynamic, NUM_PARAMETERS = Eigen::Dynamic };

    [[nodiscard]] int NumResiduals() const { return static_cast<int>(problem.residuals().size()); }
    [[nodiscard]] int NumParameters() const { return static_cast<int>(problem.free().count()); }
    bool operator()(const double* parameters, double* residuals, double* jacobian) const {
        problem.evaluate(problem.with_free(
            start, Eigen::Map<const Eigen::VectorXd>(parameters, NumParameters())));
        Eigen::Map<Eigen::VectorXd>(residuals, NumResiduals()) = problem.residuals();
        if (jacobian == nullptr)
            return true;
        problem.evaluate_jacobian();
        Eigen::Map<Eigen::MatrixXd>(jacobian, NumResiduals(), NumParameters()) = problem.jacobian();
        return true;
    }

    RingDownProblem& problem;
    const RingDownParameters& start; ///< of what is not free
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

RingDownParameters RingDownProblem::with_free(RingDownParameters at,
                                              const Eigen::VectorXd& values) const {
    for (Eigen::Index k = 0; k < free_.count(); ++k)
        at.*free_.members()[static_cast<std::size_t>(k)] = values[k];
    return at;
}

std::optional<RingDownMinimum> minimum_from(RingDownProblem& problem,
                                            const RingDownParameters& start) {
    problem.evaluate(start);
    Eigen::VectorXd values(problem.free().count());
    for (Eigen::Index k = 0; k < values.size(); ++k)
        values[k] = start.*problem.free().members()[static_cast<std::size_t>(k)];
    ceres::TinySolver<SmallProblem> solver;
    solver.options.max_num_iterations = 200;
    // Only the size of a step ends the search: sums of squares resolve half of the digits.
    solver.options.gradient_tolerance = 0.0;
    solver.options.function_tolerance = 0.0;
    solver.options.cost_threshold = 0.0;
    solver.options.parameter_tolerance = 1e-13;
    const auto summary = solver.Solve({problem, start}, &values);
    if (summary.status == solver.HIT_MAX_ITERATIONS || !values.allFinite())
        return std::nullopt;
    problem.evaluate(problem.with_free(start, values));
    problem.evaluate_jacobian();
    RingDownMinimum found{problem.with_free(start, values), problem.sum_of_squares()};
    // The solver's normal equations lose half of the digits of its last step.
    values -= problem.jacobian().householderQr().solve(problem.residuals());
    problem.evaluate(problem.with_free(start, values));
    if (problem.sum_of_squares() <= found.sum_of_squares)
        found = {problem.with_free(start, values), problem.sum_of_squares()};
    if (found.parameters.frequency < 0.0) { // the same motion
        found.parameters.frequency = -found.parameters.frequency;
        found.parameters.quadrature = -found.parameters.quadrature;
    }
    return found;
}

} // namespace culm::reduce
