// SPDX-License-Identifier: BSD-3-Clause
#include "residuals/lack_of_fit.hpp"

#include "fit/solve/residual_statistics.hpp"
#include "physics/effects/stem_scales.hpp"
#include "reduce/distributions.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <fmt/core.h>

namespace culm::residuals {
namespace {

/// Whitened residuals of one row over its noise; gaps are omitted.
std::vector<double> row_residuals(const fit::RecordingFit& fit, const Eigen::MatrixXd& whitened,
                                  std::size_t row) {
    std::vector<double> values;
    for (std::size_t i = 0; i < fit.times.size(); ++i)
        if (!std::isnan(fit.residuals[i * fit.prediction.rows + row]))
            values.push_back(
                whitened(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(row)));
    return values;
}

/// Σ w r over √Σ w² in every frame, of the residuals r over the noise and the predicted readings w
/// of the frame where they are largest over it. The variance is 1 if the residuals are noise.
std::vector<double> swing_residuals(const fit::RecordingFit& fit, const Eigen::MatrixXd& whitened) {
    const std::size_t rows = fit.prediction.rows;
    std::vector<double> weights(rows, 0.0);
    double largest = 0.0;
    for (std::size_t i = 0; i < fit.times.size(); ++i) {
        std::vector<double> frame(rows, 0.0);
        double square = 0.0;
        for (std::size_t j = 0; j < rows; ++j)
            if (const double reading = fit.prediction.readings[i * rows + j];
                !std::isnan(reading)) {
                frame[j] = reading / fit.noise[j];
                square += frame[j] * frame[j];
            }
        if (square > largest) {
            largest = square;
            weights = std::move(frame);
        }
    }
    std::vector<double> values;
    for (std::size_t i = 0; i < fit.times.size(); ++i) {
        double sum = 0.0;
        double norm = 0.0;
        for (std::size_t j = 0; j < rows; ++j) {
            if (std::isnan(fit.residuals[i * rows + j]))
                continue;
            sum +=
                weights[j] * whitened(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
            norm += weights[j] * weights[j];
        }
        if (norm > 0.0)
            values.push_back(sum / std::sqrt(norm));
    }
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

double balance_p_value(const fit::RecordingFit& fit, const Eigen::MatrixXd& whitened) {
    double sum = 0.0;
    std::size_t rows = 0;
    for (std::size_t j = 0; j < fit.prediction.rows; ++j) {
        const std::vector<double> values = row_residuals(fit, whitened, j);
        if (values.empty())
            continue;
        const double total = std::accumulate(values.begin(), values.end(), 0.0);
        // A sum of n independent residuals of unit variance has the variance n.
        sum += total * total / static_cast<double>(values.size());
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

double likeness_p_value(const fit::RecordingFit& fit, const Eigen::MatrixXd& whitened) {
    double sum = 0.0;
    std::size_t pairs = 0;
    const std::size_t rows = fit.prediction.rows;
    for (std::size_t a = 0; a < rows; ++a)
        for (std::size_t b = a + 1; b < rows; ++b) {
            double product = 0.0;
            double square_a = 0.0;
            double square_b = 0.0;
            double count = 0.0;
            for (std::size_t i = 0; i < fit.times.size(); ++i) {
                if (std::isnan(fit.residuals[i * rows + a]) ||
                    std::isnan(fit.residuals[i * rows + b]))
                    continue;
                const auto frame = static_cast<Eigen::Index>(i);
                const double left = whitened(frame, static_cast<Eigen::Index>(a));
                const double right = whitened(frame, static_cast<Eigen::Index>(b));
                product += left * right;
                square_a += left * left;
                square_b += right * right;
                count += 1.0;
            }
            if (square_a <= 0.0 || square_b <= 0.0)
                continue;
            // n r² of independent rows is χ² of one degree of freedom (Fisher 1915, large n).
            sum += count * product * product / (square_a * square_b);
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
    result.effective_degrees_of_freedom = std::min(
        fit::effective_degrees_of_freedom(whitened, lags_over_a_period(fit, swing.frequency)),
        static_cast<double>(std::max<std::size_t>(fit.degrees_of_freedom, 1)));
    // χ² of correlated residuals scatters like χ² with fewer degrees of freedom.
    if (fit.is_noise_known && fit.degrees_of_freedom > 0)
        add("size", reduce::chi_squared_p_value(fit.reduced_chi_squared *
                                                    result.effective_degrees_of_freedom,
                                                result.effective_degrees_of_freedom));
    const std::size_t lags = lags_over_a_period(fit, physics::first_frequency(fit.model.spec.stem));
    const std::vector<double> of_the_swing = swing_residuals(fit, whitened);
    add("correlation of the swing", reduce::ljung_box_p_value(of_the_swing, lags));
    add("signs of the swing", reduce::runs_p_value(of_the_swing));
    add("balance of the rows", balance_p_value(fit, whitened));
    add("likeness of the rows", likeness_p_value(fit, whitened));
    std::vector<double> rows;
    for (std::size_t j = 0; j < fit.prediction.rows; ++j) {
        rows.push_back(reduce::ljung_box_p_value(row_residuals(fit, whitened, j), lags));
        add(fmt::format("correlation at h = {:.6g} mm", 1e3 * fit.model.spec.heights[j]),
            rows.back());
    }
    add("correlation of all rows", combined_p_value(rows));
    return result;
}

} // namespace culm::residuals
