// SPDX-License-Identifier: BSD-3-Clause
#include "residuals/null_noise.hpp"

#include "fit/solve/residual_statistics.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <vector>

namespace culm::residuals {
namespace {

constexpr double largest_null_correlation = 0.95;
constexpr std::uint64_t seed = 0x63756c6dULL;

/// Standard normal numbers by Box and Muller's method: the same with every library.
class NormalNumbers {
  public:
    explicit NormalNumbers(std::uint64_t draw) : engine_(seed + draw * 0x9e3779b97f4a7c15ULL) {}
    [[nodiscard]] double operator()() {
        if (has_second_) {
            has_second_ = false;
            return second_;
        }
        const double radius = std::sqrt(-2.0 * std::log(uniform()));
        const double angle = 2.0 * std::numbers::pi * uniform();
        second_ = radius * std::sin(angle);
        has_second_ = true;
        return radius * std::cos(angle);
    }

  private:
    /// In (0, 1).
    [[nodiscard]] double uniform() {
        return (static_cast<double>(engine_() >> 11) + 0.5) * 0x1.0p-53;
    }
    std::mt19937_64 engine_;
    double second_ = 0.0;
    bool has_second_ = false;
};

/// Correlation of neighbouring frames; 0 within two standard errors of it.
double frame_correlation(const Eigen::MatrixXd& whitened, Eigen::Index row) {
    double product = 0.0;
    double square = 0.0;
    for (Eigen::Index i = 1; i < whitened.rows(); ++i) {
        product += whitened(i, row) * whitened(i - 1, row);
        square += whitened(i, row) * whitened(i, row);
    }
    const double correlation = square > 0.0 ? product / square : 0.0;
    const double chance =
        2.0 / std::sqrt(static_cast<double>(std::max<Eigen::Index>(whitened.rows(), 1)));
    return correlation > chance ? std::min(correlation, largest_null_correlation) : 0.0;
}

} // namespace

Eigen::MatrixXd null_noise(const fit::Fit& fit, int draws) {
    std::vector<std::vector<double>> correlations; // (recordings)(rows)
    Eigen::Index readings = 0;
    for (const fit::RecordingFit& part : fit.parts) {
        const Eigen::MatrixXd whitened = fit::whitened_residuals(part);
        std::vector<double>& rows = correlations.emplace_back();
        for (Eigen::Index j = 0; j < whitened.cols(); ++j)
            rows.push_back(frame_correlation(whitened, j));
        readings += static_cast<Eigen::Index>(part.residuals.size());
    }
    Eigen::MatrixXd noise = Eigen::MatrixXd::Zero(readings, draws);
    for (Eigen::Index draw = 0; draw < noise.cols(); ++draw) {
        NormalNumbers normal(static_cast<std::uint64_t>(draw));
        Eigen::Index begin = 0;
        for (std::size_t m = 0; m < fit.parts.size(); ++m) {
            const std::vector<double>& residuals = fit.parts[m].residuals;
            const std::size_t rows = correlations[m].size();
            for (std::size_t j = 0; j < rows; ++j) {
                const double correlation = correlations[m][j];
                const double fresh = std::sqrt(1.0 - correlation * correlation);
                double value = normal();
                for (std::size_t place = j; place < residuals.size(); place += rows) {
                    if (!std::isnan(residuals[place]))
                        noise(begin + static_cast<Eigen::Index>(place), draw) = value;
                    value = correlation * value + fresh * normal();
                }
            }
            begin += static_cast<Eigen::Index>(residuals.size());
        }
    }
    return noise;
}

} // namespace culm::residuals
