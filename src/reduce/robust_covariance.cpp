// SPDX-License-Identifier: BSD-3-Clause
#include "reduce/robust_covariance.hpp"

#include "core/error.hpp"
#include "reduce/residual_tests.hpp"

#include <algorithm>

#include <Eigen/LU>
#include <Eigen/QR>

namespace culm::reduce {

namespace {

/// Σ w(lag) Σ_t (a_t b_{t+lag}ᵀ + transpose) over the rows of `rows`; lag 0 once.
Eigen::MatrixXd lagged_sum(const Eigen::MatrixXd& rows, std::span<const double> weights) {
    const Eigen::Index n = rows.rows();
    Eigen::MatrixXd sum = weights[0] * (rows.transpose() * rows);
    for (std::size_t lag = 1; lag < weights.size(); ++lag) {
        const auto shift = static_cast<Eigen::Index>(lag);
        if (shift >= n)
            break;
        const Eigen::MatrixXd product =
            rows.topRows(n - shift).transpose() * rows.bottomRows(n - shift);
        sum += weights[lag] * (product + product.transpose());
    }
    return sum;
}

} // namespace

double FitCovariances::variance(const Eigen::VectorXd& direction) const {
    return std::max({direction.dot(independent * direction), direction.dot(stationary * direction),
                     direction.dot(newey_west * direction)});
}

FitCovariances fit_covariances(const Eigen::MatrixXd& jacobian, std::span<const double> residuals,
                               std::size_t lags) {
    const Eigen::Index n = jacobian.rows();
    const Eigen::Index parameters = jacobian.cols();
    const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(jacobian);
    if (n <= parameters || qr.rank() < parameters)
        throw core::NumericalError(core::FailureKind::FitFailed,
                                   "the samples do not tell all parameters of Eq. 1 apart");
    const Eigen::MatrixXd bread = (jacobian.transpose() * jacobian).inverse();
    const double scale = static_cast<double>(n) / static_cast<double>(n - parameters);
    std::vector<double> covariance = autocovariance(residuals, lags);
    std::vector<double> weights(covariance.size());
    for (std::size_t lag = 0; lag < weights.size(); ++lag) {
        weights[lag] = 1.0 - static_cast<double>(lag) / static_cast<double>(lags + 1);
        covariance[lag] *= weights[lag];
    }
    const Eigen::Map<const Eigen::VectorXd> errors(residuals.data(), n);
    const Eigen::MatrixXd scores = jacobian.array().colwise() * errors.array();
    return {scale * covariance[0] * bread,
            scale * (bread * lagged_sum(jacobian, covariance) * bread),
            scale * (bread * lagged_sum(scores, weights) * bread)};
}

} // namespace culm::reduce
