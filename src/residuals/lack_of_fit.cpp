// SPDX-License-Identifier: BSD-3-Clause
#include "residuals/lack_of_fit.hpp"

#include "fit/solve/residual_statistics.hpp"
#include "physics/effects/stem_scales.hpp"
#include "reduce/distributions.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/core.h>

namespace culm::residuals {
namespace {

/// (frames, rows), 1 where a reading was seen and 0 elsewhere; the whitened residuals are 0 there.
Eigen::MatrixXd seen_readings(const fit::RecordingFit& fit, const Eigen::MatrixXd& whitened) {
    const Eigen::Map<const RowMajorMatrix> residuals(fit.residuals.data(), whitened.rows(),
                                                     whitened.cols());
    return (!residuals.array().isNaN()).cast<double>();
}

/// Whitened residuals of one row over its noise; gaps are omitted.
std::vector<double> row_residuals(const Eigen::MatrixXd& whitened, const Eigen::MatrixXd& seen,
                                  Eigen::Index row) {
    std::vector<double> values;
    for (Eigen::Index i = 0; i < whitened.rows(); ++i)
        if (seen(i, row) > 0.0)
            values.push_back(whitened(i, row));
    return values;
}

/// Σ w r over √Σ w² in every frame, of the residuals r over the noise and the predicted readings w
/// of the frame where they are largest over it. The variance is 1 if the residuals are noise.
std::vector<double> swing_residuals(const fit::RecordingFit& fit, const Eigen::MatrixXd& whitened,
                                    const Eigen::MatrixXd& seen) {
    const Eigen::MatrixXd predicted = over_noise(fit, fit.prediction.readings);
    Eigen::Index largest = 0;
    predicted.rowwise().squaredNorm().maxCoeff(&largest);
    const Eigen::VectorXd weights = predicted.row(largest);
    const Eigen::VectorXd sums = whitened * weights;
    const Eigen::VectorXd squares = seen * weights.cwiseAbs2();
    std::vector<double> values;
    for (Eigen::Index i = 0; i < sums.size(); ++i)
        if (squares(i) > 0.0)
            values.push_back(sums(i) / std::sqrt(squares(i)));
    return values;
}

/// Frames in a period, at most a fifth of them all.
std::size_t lags_over_a_period(const fit::RecordingFit& fit, double frequency) {
    const std::size_t frames = fit.times.size();
    if (frames < 10)
        return 1;
    const double interval =
        (fit.times.back() - fit.times.front()) / static_cast<double>(frames - 1);
    const auto lags = static_cast<std::size_t>(std::lround(1.0 / (frequency * interval)));
    return std::clamp<std::size_t>(lags, 2, frames / 5);
}

double balance_p_value(const Eigen::MatrixXd& whitened, const Eigen::MatrixXd& seen) {
    const Eigen::RowVectorXd totals = whitened.colwise().sum();
    const Eigen::RowVectorXd counts = seen.colwise().sum();
    double sum = 0.0;
    std::size_t rows = 0;
    for (Eigen::Index j = 0; j < totals.size(); ++j) {
        if (counts(j) == 0.0)
            continue;
        // A sum of n independent residuals of unit variance has the variance n.
        sum += totals(j) * totals(j) / counts(j);
        ++rows;
    }
    return rows == 0 ? 1.0 : reduce::chi_squared_p_value(sum, double(rows));
}

/// Fisher (1925): −2 Σ ln p is χ² with two degrees of freedom per test.
double combined_p_value(const std::vector<double>& p_values) {
    double sum = 0.0;
    for (const double p : p_values)
        sum -= 2.0 * std::log(std::max(p, 1e-300));
    return p_values.empty() ? 1.0 : reduce::chi_squared_p_value(sum, 2.0 * double(p_values.size()));
}

double likeness_p_value(const Eigen::MatrixXd& whitened, const Eigen::MatrixXd& seen) {
    // (rows, rows), over the frames in which both rows were seen; the squares are of the first row.
    const Eigen::MatrixXd products = whitened.transpose() * whitened;
    const Eigen::MatrixXd squares = whitened.cwiseAbs2().transpose() * seen;
    const Eigen::MatrixXd counts = seen.transpose() * seen;
    double sum = 0.0;
    std::size_t pairs = 0;
    for (Eigen::Index a = 0; a < products.rows(); ++a)
        for (Eigen::Index b = a + 1; b < products.rows(); ++b) {
            if (squares(a, b) <= 0.0 || squares(b, a) <= 0.0)
                continue;
            // n r² of independent rows is χ² of one degree of freedom (Fisher 1915, large n).
            sum += counts(a, b) * products(a, b) * products(a, b) / (squares(a, b) * squares(b, a));
            ++pairs;
        }
    return pairs == 0 ? 1.0 : reduce::chi_squared_p_value(sum, double(pairs));
}

} // namespace

LackOfFit test_lack_of_fit(const fit::RecordingFit& fit, const Swing& swing) {
    LackOfFit result;
    const auto add = [&result](std::string name, double p_value) {
        result.tests.push_back({std::move(name), p_value, p_value});
    };
    const Eigen::MatrixXd whitened = fit::whitened_residuals(fit);
    const Eigen::MatrixXd seen = seen_readings(fit, whitened);
    result.effective_degrees_of_freedom = std::min(
        fit::effective_degrees_of_freedom(whitened, lags_over_a_period(fit, swing.frequency)),
        static_cast<double>(std::max<std::size_t>(fit.degrees_of_freedom, 1)));
    // χ² of correlated residuals scatters like χ² with fewer degrees of freedom.
    if (fit.is_noise_known && fit.degrees_of_freedom > 0)
        add("size", reduce::chi_squared_p_value(fit.reduced_chi_squared *
                                                    result.effective_degrees_of_freedom,
                                                result.effective_degrees_of_freedom));
    const std::size_t lags = lags_over_a_period(fit, physics::first_frequency(fit.model.spec.stem));
    const std::vector<double> of_the_swing = swing_residuals(fit, whitened, seen);
    add("correlation of the swing", reduce::ljung_box_p_value(of_the_swing, lags));
    add("signs of the swing", reduce::runs_p_value(of_the_swing));
    add("balance of the rows", balance_p_value(whitened, seen));
    add("likeness of the rows", likeness_p_value(whitened, seen));
    std::vector<double> rows;
    for (std::size_t j = 0; j < fit.prediction.rows; ++j) {
        rows.push_back(reduce::ljung_box_p_value(
            row_residuals(whitened, seen, static_cast<Eigen::Index>(j)), lags));
        add(fmt::format("correlation at h = {:.6g} mm", 1e3 * fit.model.spec.heights[j]),
            rows.back());
    }
    add("correlation of all rows", combined_p_value(rows));
    return result;
}

} // namespace culm::residuals
