// SPDX-License-Identifier: BSD-3-Clause
#include "reduce/ring_down/ring_down_analysis.hpp"

#include "core/error.hpp"
#include "core/order_statistics.hpp"
#include "reduce/distributions.hpp"
#include "reduce/ring_down/ring_down_model.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/LU>
#include <Eigen/QR>
#include <fmt/format.h>

namespace culm::reduce {
namespace {

/// Covariances of the same fit by three assumptions, each (parameters, parameters).
struct FitCovariances {
    Eigen::MatrixXd independent; ///< residuals independent, of one variance
    Eigen::MatrixXd stationary;  ///< residuals correlated the same way everywhere
    Eigen::MatrixXd newey_west;  ///< any weak correlation and any variance (Newey & West 1987)

    /// Largest variance of the linear combination `direction` of the parameters.
    [[nodiscard]] double variance(const Eigen::VectorXd& direction) const {
        return std::max({direction.dot(independent * direction),
                         direction.dot(stationary * direction),
                         direction.dot(newey_west * direction)});
    }
};

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

/// `jacobian` has the shape (samples, parameters), `residuals` (samples). Correlations are used
/// up to `lags` samples, with Bartlett's weights. All are scaled by n/(n − parameters). Throws
/// core::NumericalError (FitFailed) if the Jacobian is rank deficient.
FitCovariances fit_covariances(const Eigen::MatrixXd& jacobian, std::span<const double> residuals,
                               std::size_t lags) {
    const Eigen::Index n = jacobian.rows();
    const Eigen::Index parameters = jacobian.cols();
    const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(jacobian);
    if (n <= parameters || qr.rank() < parameters)
        throw core::NumericalError(core::FailureKind::FitFailed,
                                   "the samples do not determine all parameters of Eq. 1");
    // The sandwich (XᵀX)⁻¹ M (XᵀX)⁻¹ with M the covariance of Xᵀe.
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

constexpr double adequacy_significance = 0.01;

/// Order of the parameters: b0, b1, b2, then the offset, then the phase, those that are free.
struct Model {
    bool has_offset = false;
    bool has_phase = false;

    [[nodiscard]] Eigen::Index size() const {
        return 3 + (has_offset ? 1 : 0) + (has_phase ? 1 : 0);
    }
    [[nodiscard]] double offset(const Eigen::VectorXd& p) const { return has_offset ? p[3] : 0.0; }
    [[nodiscard]] double phase(const Eigen::VectorXd& p) const {
        return has_phase ? p[size() - 1] : 0.0;
    }
};

RingDownSamples samples_used(std::span<const double> times, std::span<const double> deflections,
                             const std::optional<double>& window) {
    RingDownSamples used;
    for (std::size_t i = 0; i < times.size(); ++i)
        if (times[i] >= 0.0 && (!window || times[i] <= *window) && !std::isnan(deflections[i])) {
            used.times.push_back(times[i]);
            used.values.push_back(deflections[i]);
        }
    return used;
}

/// Residuals (measured − model) and the model's Jacobian.
struct Linearisation {
    Eigen::VectorXd residuals;
    Eigen::MatrixXd jacobian;
};

Linearisation linearise(const RingDownSamples& samples, const Model& model,
                        const Eigen::VectorXd& p) {
    const auto n = static_cast<Eigen::Index>(samples.times.size());
    Linearisation result{Eigen::VectorXd(n), Eigen::MatrixXd(n, model.size())};
    for (Eigen::Index i = 0; i < n; ++i) {
        const double t = samples.times[static_cast<std::size_t>(i)];
        const double envelope = std::exp(p[1] * t);
        const double angle = two_pi * p[2] * t + model.phase(p);
        const double cosine = envelope * std::cos(angle);
        const double sine = envelope * std::sin(angle);
        result.residuals[i] =
            samples.values[static_cast<std::size_t>(i)] - model.offset(p) - p[0] * cosine;
        result.jacobian(i, 0) = cosine;
        result.jacobian(i, 1) = p[0] * t * cosine;
        result.jacobian(i, 2) = -p[0] * two_pi * t * sine;
        if (model.has_offset)
            result.jacobian(i, 3) = 1.0;
        if (model.has_phase)
            result.jacobian(i, model.size() - 1) = -p[0] * sine;
    }
    return result;
}

/// Levenberg-Marquardt with the scaling of Moré (1978), from a start near the minimum.
Eigen::VectorXd minimised(const RingDownSamples& samples, const Model& model,
                          Eigen::VectorXd parameters) {
    double damping = 1e-3;
    Linearisation now = linearise(samples, model, parameters);
    constexpr int most_steps = 200;
    for (int step = 0; step < most_steps; ++step) {
        const Eigen::MatrixXd normal = now.jacobian.transpose() * now.jacobian;
        Eigen::MatrixXd damped = normal;
        damped.diagonal() *= 1.0 + damping;
        const Eigen::VectorXd change =
            damped.ldlt().solve(now.jacobian.transpose() * now.residuals);
        const Eigen::VectorXd trial = parameters + change;
        const Linearisation next = linearise(samples, model, trial);
        if (!(next.residuals.squaredNorm() <= now.residuals.squaredNorm())) {
            damping *= 10.0;
            if (damping > 1e12)
                break;
            continue;
        }
        // The fit has converged if the step changes the model by less than this share of it.
        const bool is_done = (now.jacobian * change).norm() <=
                             1e-12 * std::max(now.residuals.norm(), 1e-3 * std::abs(parameters[0]));
        parameters = trial;
        now = next;
        damping = std::max(0.1 * damping, 1e-12);
        if (is_done)
            break;
    }
    return parameters;
}

/// Mean over the last tenth of the record, where the motion has decayed most.
double rest_level(const std::vector<double>& values) {
    const std::size_t tail = std::max<std::size_t>(1, values.size() / 10);
    double sum = 0.0;
    for (std::size_t i = values.size() - tail; i < values.size(); ++i)
        sum += values[i];
    return sum / static_cast<double>(tail);
}

Eigen::VectorXd fitted(const RingDownSamples& samples, const Model& model) {
    const double offset =
        model.has_offset && !samples.values.empty() ? rest_level(samples.values) : 0.0;
    std::vector<double> values = samples.values;
    for (double& value : values)
        value -= offset;
    const RingDownFit start = fit_ring_down(samples.times, values);
    Eigen::VectorXd parameters = Eigen::VectorXd::Zero(model.size());
    parameters[0] = start.amplitude * start.deflection_scale;
    parameters[1] = start.decay_rate;
    parameters[2] = start.frequency;
    if (model.has_offset)
        parameters[3] = offset;
    return model.size() == 3 ? parameters : minimised(samples, model, parameters);
}

void set_estimates(const Eigen::VectorXd& p, const Model& model, const FitCovariances& covariances,
                   double factor, RingDownAnalysis& analysis) {
    const auto of = [&](Eigen::Index index) {
        return estimate(p[index], covariances.variance(Eigen::VectorXd::Unit(p.size(), index)),
                        factor);
    };
    analysis.amplitude = of(0);
    analysis.decay_rate = of(1);
    analysis.frequency = of(2);
    // Gradient of b1/b2.
    Eigen::VectorXd direction = Eigen::VectorXd::Zero(p.size());
    direction[1] = 1.0 / p[2];
    direction[2] = -p[1] / (p[2] * p[2]);
    analysis.decay_per_cycle = estimate(p[1] / p[2], covariances.variance(direction), factor);
    analysis.independent_decay_error =
        std::sqrt(direction.dot(covariances.independent * direction));
    if (model.has_offset)
        analysis.offset = of(3);
    if (model.has_phase)
        analysis.phase = of(p.size() - 1);
}

/// Lags of the correlation: one period, but at most a fifth of the record.
std::size_t lags_of(const RingDownSamples& samples, double frequency) {
    const double period = 1.0 / (frequency * core::median_interval(samples.times));
    const auto n = static_cast<double>(samples.times.size());
    const double automatic = 4.0 * std::pow(n / 100.0, 2.0 / 9.0); // Newey & West (1994)
    return static_cast<std::size_t>(
        std::clamp(std::ceil(std::max(period, automatic)), 1.0, std::max(1.0, n / 5.0)));
}

/// Tests whether the residuals are larger than the noise (χ²), correlated (Ljung & Box 1978), or of
/// one sign for too long (runs; Wald & Wolfowitz 1940).
RingDownAdequacy judge(const std::vector<double>& residuals, std::size_t lags,
                       std::size_t parameters, const std::optional<double>& noise) {
    RingDownAdequacy adequacy;
    adequacy.ljung_box_p_value = ljung_box_p_value(residuals, lags);
    adequacy.runs_p_value = runs_p_value(residuals);
    std::vector<std::string> reasons;
    if (noise && residuals.size() > parameters) {
        double sum = 0.0;
        for (const double residual : residuals)
            sum += residual * residual;
        const double freedom = static_cast<double>(residuals.size() - parameters);
        sum /= *noise * *noise;
        adequacy.reduced_chi_squared = sum / freedom;
        adequacy.chi_squared_p_value = chi_squared_p_value(sum, freedom);
        if (*adequacy.chi_squared_p_value < adequacy_significance)
            reasons.push_back(
                fmt::format("residuals {:.2g} x noise", std::sqrt(*adequacy.reduced_chi_squared)));
    }
    if (std::min(adequacy.ljung_box_p_value, adequacy.runs_p_value) < adequacy_significance)
        reasons.emplace_back("correlated");
    adequacy.is_adequate = reasons.empty();
    for (const std::string& reason : reasons)
        adequacy.reason += (adequacy.reason.empty() ? "" : ", ") + reason;
    return adequacy;
}

double variation(const std::vector<double>& values) {
    double mean = 0.0;
    for (const double value : values)
        mean += value / static_cast<double>(values.size());
    double sum = 0.0;
    for (const double value : values)
        sum += (value - mean) * (value - mean);
    return sum;
}

} // namespace

RingDownAnalysis analyse_ring_down(std::span<const double> times,
                                   std::span<const double> deflections,
                                   const RingDownAnalysisOptions& options) {
    const RingDownSamples samples = samples_used(times, deflections, options.window);
    const Model model{options.has_offset, options.has_phase};
    const auto needed = static_cast<std::size_t>(model.size()) + 2;
    if (samples.times.size() < needed)
        throw core::NumericalError(
            core::FailureKind::FitFailed,
            fmt::format("Eq. 1 needs at least {} readings after the release, there are {}", needed,
                        samples.times.size()));
    const Eigen::VectorXd parameters = fitted(samples, model);
    const Linearisation last = linearise(samples, model, parameters);
    RingDownAnalysis analysis;
    analysis.samples = samples.times.size();
    analysis.residuals.assign(last.residuals.begin(), last.residuals.end());
    for (const double value : samples.values)
        analysis.largest_deflection = std::max(analysis.largest_deflection, std::abs(value));
    const std::size_t lags = lags_of(samples, parameters[2]);
    const FitCovariances covariances = fit_covariances(last.jacobian, analysis.residuals, lags);
    const auto freedom = analysis.samples - static_cast<std::size_t>(model.size());
    set_estimates(parameters, model, covariances, student_t_factor(freedom), analysis);
    const double sum = last.residuals.squaredNorm();
    analysis.rms_residual = std::sqrt(sum / static_cast<double>(analysis.samples));
    analysis.r_squared = 1.0 - sum / variation(samples.values);
    analysis.adequacy =
        judge(analysis.residuals, lags, static_cast<std::size_t>(model.size()), options.noise);
    return analysis;
}

} // namespace culm::reduce
