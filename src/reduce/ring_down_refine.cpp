// SPDX-License-Identifier: BSD-3-Clause
#include "reduce/ring_down_refine.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <ceres/ceres.h>

namespace culm::reduce {

namespace {

/// Residuals of all samples in one block; parameters (b0) and (b1, b2) per `period`, so that all
/// three are of order one.
class RingDownCost final : public ceres::CostFunction {
  public:
    RingDownCost(const RingDownSamples& samples, double period)
        : samples_(samples), rate_(1.0 / period) {
        set_num_residuals(static_cast<int>(samples.times.size()));
        *mutable_parameter_block_sizes() = std::vector<std::int32_t>{1, 2};
    }

    bool Evaluate(double const* const* parameters, double* residuals,
                  double** jacobians) const override {
        double* by_amplitude = jacobians != nullptr ? jacobians[0] : nullptr;
        double* by_shape = jacobians != nullptr ? jacobians[1] : nullptr;
        const RingDownParameters trial{parameters[0][0], parameters[1][0] * rate_,
                                       parameters[1][1] * rate_};
        for (std::size_t i = 0; i < samples_.times.size(); ++i) {
            const RingDownPoint point = evaluate_ring_down(trial, samples_.times[i]);
            residuals[i] = point.value - samples_.values[i];
            if (!std::isfinite(residuals[i]))
                return false;
            if (by_amplitude != nullptr)
                by_amplitude[i] = point.gradient[0];
            if (by_shape != nullptr) {
                by_shape[2 * i] = point.gradient[1] * rate_;
                by_shape[2 * i + 1] = point.gradient[2] * rate_;
            }
        }
        return true;
    }

  private:
    const RingDownSamples& samples_;
    double rate_;
};

ceres::Solver::Options solver_options() {
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::DENSE_QR;
    options.logging_type = ceres::SILENT;
    options.max_num_iterations = 200;
    // Loose enough to stop at rounding level; polish_ring_down does the last digits.
    options.function_tolerance = 1e-14;
    options.gradient_tolerance = 1e-14;
    options.parameter_tolerance = 1e-12;
    options.num_threads = 1;
    return options;
}

/// First and second derivatives of half the sum of squares.
struct Curvature {
    double residual_sum_of_squares = 0.0;
    Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
    Eigen::Matrix3d gauss_newton = Eigen::Matrix3d::Zero();
    Eigen::Matrix3d newton = Eigen::Matrix3d::Zero();
};

Curvature curvature(const RingDownSamples& samples, const RingDownParameters& parameters,
                    bool amplitude_is_free) {
    Curvature sum;
    for (std::size_t i = 0; i < samples.times.size(); ++i) {
        const RingDownPoint point = evaluate_ring_down(parameters, samples.times[i]);
        const double residual = point.value - samples.values[i];
        sum.residual_sum_of_squares += residual * residual;
        sum.gradient += residual * point.gradient;
        sum.gauss_newton += point.gradient * point.gradient.transpose();
        sum.newton += residual * ring_down_hessian(parameters, samples.times[i], point.gradient);
    }
    sum.newton += sum.gauss_newton;
    if (amplitude_is_free)
        return sum;
    // A fixed amplitude: its equation becomes "step = 0".
    sum.gradient[0] = 0.0;
    for (Eigen::Matrix3d* matrix : {&sum.gauss_newton, &sum.newton}) {
        matrix->row(0).setZero();
        matrix->col(0).setZero();
        (*matrix)(0, 0) = 1.0;
    }
    return sum;
}

/// The Newton step, or the Gauss-Newton step where the Hessian is not positive definite.
Eigen::Vector3d minimising_step(const Curvature& at) {
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

} // namespace

std::optional<RefinedRingDown> refine_ring_down(const RingDownSamples& samples,
                                                const RingDownParameters& start,
                                                bool amplitude_is_free) {
    double amplitude = start.amplitude;
    std::array<double, 2> shape = {start.decay_rate / start.frequency, 1.0};
    ceres::Problem problem;
    problem.AddResidualBlock(new RingDownCost(samples, 1.0 / start.frequency), nullptr, &amplitude,
                             shape.data());
    if (!amplitude_is_free)
        problem.SetParameterBlockConstant(&amplitude);
    ceres::Solver::Summary summary;
    ceres::Solve(solver_options(), &problem, &summary);
    if (!summary.IsSolutionUsable())
        return std::nullopt;
    RefinedRingDown refined;
    refined.parameters = {amplitude, shape[0] * start.frequency,
                          std::abs(shape[1]) * start.frequency};
    refined.residual_sum_of_squares = 2.0 * summary.final_cost;
    refined.iterations = static_cast<int>(summary.iterations.size());
    return refined;
}

bool polish_ring_down(const RingDownSamples& samples, bool amplitude_is_free,
                      RefinedRingDown& refined) {
    constexpr int most_iterations = 12;
    constexpr double rounding = 1e-14;
    double previous = std::numeric_limits<double>::infinity();
    for (int iteration = 0; iteration < most_iterations; ++iteration) {
        RingDownParameters& at = refined.parameters;
        const Curvature here = curvature(samples, at, amplitude_is_free);
        refined.residual_sum_of_squares = here.residual_sum_of_squares;
        const Eigen::Vector3d step = minimising_step(here);
        const double size = relative_size(step, at);
        // Steps that are small and shrink no more consist of rounding.
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
    Eigen::MatrixXd jacobian(rows, free);
    for (Eigen::Index i = 0; i < rows; ++i)
        jacobian.row(i) =
            evaluate_ring_down(refined.parameters, samples.times[static_cast<std::size_t>(i)])
                .gradient.tail(free);
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
