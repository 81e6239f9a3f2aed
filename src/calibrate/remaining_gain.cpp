// SPDX-License-Identifier: BSD-3-Clause
#include "calibrate/remaining_gain.hpp"

#include "calibrate/information_directions.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Core>

namespace culm::calibrate {
namespace {

/// Jᵀ W J and Jᵀ W r.
struct NormalEquations {
    Eigen::MatrixXd information;
    Eigen::VectorXd gradient;
};

NormalEquations normal_equations(const JointResiduals& residuals,
                                 std::optional<double> robust_width) {
    const auto count = static_cast<Eigen::Index>(residuals.parameter_count());
    NormalEquations sums{Eigen::MatrixXd::Zero(count, count), Eigen::VectorXd::Zero(count)};
    Eigen::VectorXd slope(count);
    for (std::size_t part = 0; part < residuals.parts().size(); ++part)
        for (const ReadingResiduals::Place& place : residuals.parts()[part].places()) {
            double residual = 0.0;
            if (!residuals.evaluate(part, place, &residual, slope.data()) || !slope.allFinite())
                continue;
            const double weight = robust_width && std::abs(residual) > *robust_width
                                      ? *robust_width / std::abs(residual)
                                      : 1.0;
            sums.information.selfadjointView<Eigen::Lower>().rankUpdate(slope, weight);
            sums.gradient += weight * residual * slope;
        }
    sums.information = sums.information.selfadjointView<Eigen::Lower>();
    return sums;
}

/// Downhill is where the gradient does not point.
bool can_move(const JointResiduals& residuals, std::size_t k, double gradient) {
    const double internal = residuals.internal()[k];
    return gradient > 0.0 ? internal > residuals.lower(k) : internal < residuals.upper(k);
}

} // namespace

double remaining_gain(const JointResiduals& residuals, const std::vector<bool>& is_held,
                      std::optional<double> robust_width) {
    const NormalEquations sums = normal_equations(residuals, robust_width);
    std::vector<Eigen::Index> moving;
    for (std::size_t k = 0; k < residuals.parameter_count(); ++k) {
        const auto at = static_cast<Eigen::Index>(k);
        const bool is_free = k >= is_held.size() || !is_held[k];
        if (is_free && sums.information(at, at) > 0.0 && can_move(residuals, k, sums.gradient(at)))
            moving.push_back(at);
    }
    if (moving.empty())
        return 0.0;
    const InformationDirections told = information_directions(sums.information(moving, moving));
    const Eigen::VectorXd gradient = sums.gradient(moving).cwiseQuotient(told.scale);
    double gain = 0.0;
    for (Eigen::Index k = 0; k < told.information.size(); ++k)
        if (told.is_known(k))
            gain += std::pow(told.directions.col(k).dot(gradient), 2) / told.information(k);
    return gain;
}

} // namespace culm::calibrate
