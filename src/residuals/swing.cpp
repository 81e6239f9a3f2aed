// SPDX-License-Identifier: BSD-3-Clause
#include "residuals/swing.hpp"

#include "physics/effects/stem_scales.hpp"
#include "run/modes.hpp"

#include <cmath>
#include <limits>

#include <Eigen/Eigenvalues>

namespace culm::residuals {
namespace {

/// Σ over the frames after the release of readings of two rows over their noise.
Eigen::MatrixXd row_products(const fit::RecordingFit& fit, const std::vector<double>& readings) {
    const auto rows = static_cast<Eigen::Index>(fit.prediction.rows);
    Eigen::MatrixXd products = Eigen::MatrixXd::Zero(rows, rows);
    for (std::size_t i = 0; i < fit.times.size(); ++i) {
        if (fit.times[i] < 0.0)
            continue;
        Eigen::VectorXd frame = Eigen::VectorXd::Zero(rows);
        for (Eigen::Index j = 0; j < rows; ++j) {
            const auto row = static_cast<std::size_t>(j);
            const double reading = readings[i * fit.prediction.rows + row];
            if (!std::isnan(reading))
                frame(j) = reading / fit.noise[row];
        }
        products += frame * frame.transpose();
    }
    return products;
}

std::vector<double> strongest_shape(const fit::RecordingFit& fit,
                                    const measure::Measurement& measurement) {
    Eigen::MatrixXd products = row_products(fit, fit.prediction.readings);
    if (!(products.trace() > 0.0))
        products = row_products(fit, measurement.deflections);
    // The leading eigenvector of YᵀY: no other shape takes up more of the motion (first principal
    // component, with readings in units of their noise).
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(products);
    const Eigen::VectorXd strongest = solver.eigenvectors().col(products.rows() - 1);
    std::vector<double> shape;
    double largest = 0.0;
    for (Eigen::Index j = 0; j < strongest.size(); ++j) {
        shape.push_back(strongest(j) * fit.noise[static_cast<std::size_t>(j)]);
        if (std::abs(shape.back()) > std::abs(largest))
            largest = shape.back();
    }
    for (double& entry : shape)
        entry /= largest == 0.0 ? 1.0 : largest;
    return shape;
}

/// Least-squares coordinate of one frame in the shape, over the rows that both tables have.
class SwingProjection {
  public:
    SwingProjection(const fit::RecordingFit& fit, const std::vector<double>& shape)
        : fit_(fit), shape_(shape) {}

    template <class Reading>
    [[nodiscard]] double operator()(std::size_t frame, const Reading& reading) const {
        // q = Σ w s y/Σ w s² minimises Σ w (y − q s)², w = 1/σ².
        double sum = 0.0;
        double norm = 0.0;
        for (std::size_t j = 0; j < shape_.size(); ++j) {
            if (std::isnan(fit_.residuals[frame * shape_.size() + j]))
                continue;
            const double precision = 1.0 / (fit_.noise[j] * fit_.noise[j]);
            sum += precision * shape_[j] * reading(frame * shape_.size() + j);
            norm += precision * shape_[j] * shape_[j];
        }
        return norm > 0.0 ? sum / norm : std::numeric_limits<double>::quiet_NaN();
    }

  private:
    const fit::RecordingFit& fit_;
    const std::vector<double>& shape_;
};

} // namespace

Swing swing_of(const fit::RecordingFit& fit, const measure::Measurement& measurement) {
    Swing swing;
    swing.shape = strongest_shape(fit, measurement);
    swing.times = fit.times;
    const SwingProjection project(fit, swing.shape);
    const std::size_t parameters = fit.prediction.parameters;
    const std::size_t release = fit.model.first_error() - 1;
    for (std::size_t i = 0; i < fit.times.size(); ++i) {
        swing.modelled.push_back(
            project(i, [&](std::size_t place) { return fit.prediction.readings[place]; }));
        swing.measured.push_back(
            project(i, [&](std::size_t place) { return measurement.deflections[place]; }));
        // The derivative by the release time is −dy/dt.
        swing.modelled_speed.push_back(project(i, [&](std::size_t place) {
            const double derivative = fit.prediction.jacobian[place * parameters + release];
            return std::isfinite(derivative) ? -derivative : 0.0;
        }));
    }
    // Of q in a frame without gaps: var q = 1/Σ w s².
    double precision = 0.0;
    for (std::size_t j = 0; j < swing.shape.size(); ++j)
        precision += std::pow(swing.shape[j] / fit.noise[j], 2);
    swing.noise = precision > 0.0 ? 1.0 / std::sqrt(precision) : 0.0;
    const auto modes = run::chain_modes(fit.model.spec, 1);
    swing.frequency =
        modes.empty() ? physics::first_frequency(fit.model.spec.stem) : modes.front().frequency;
    return swing;
}

} // namespace culm::residuals
