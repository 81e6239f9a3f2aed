// SPDX-License-Identifier: BSD-3-Clause
#include "reduce/backbone/damped_modes.hpp"

#include "core/error.hpp"
#include "core/order_statistics.hpp"
#include "reduce/ring_down/ring_down_fit.hpp"
#include "reduce/ring_down/ring_down_model.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Dense>

namespace culm::reduce {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int most_iterations = 60;
constexpr double farthest = 0.25;         ///< of a start's frequency
constexpr double smallest_change = 1e-10; ///< relative, of the sum of squares

/// The basis functions and their derivatives by the free numbers, for one height.
struct Basis {
    MatrixXd functions;               ///< (samples, 1 + 2 modes)
    std::vector<MatrixXd> by_numbers; ///< (free numbers)(samples, 2): of the two of one mode
    std::vector<Index> first;         ///< (free numbers) column of these two
};

class Projection {
  public:
    Projection(const HeightHistories& of, std::span<const ModeRate> rates) {
        for (std::size_t j = 0; j < of.histories.size(); ++j) {
            std::vector<Index> seen;
            for (std::size_t i = 0; i < of.times.size(); ++i)
                if (std::isfinite(of.histories[j][i]))
                    seen.push_back(static_cast<Index>(i));
            add_height(of, rates, j, seen);
        }
    }

    /// Reduced Jacobian and residual over all heights.
    MatrixXd jacobian;
    VectorXd residual;
    std::vector<VectorXd> coefficients; ///< (heights) offset, then c and −s of each mode
    std::vector<MatrixXd> covariances;  ///< (heights) of them for unit noise, other numbers fixed
    std::vector<std::vector<Index>> seen;

  private:
    static Basis basis_of(const HeightHistories& of, std::span<const ModeRate> rates,
                          const std::vector<Index>& seen) {
        const auto n = static_cast<Index>(seen.size());
        Basis basis{MatrixXd::Ones(n, 1 + 2 * std::ssize(rates)), {}, {}};
        Eigen::ArrayXd time(n);
        for (Index i = 0; i < n; ++i)
            time[i] = of.times[static_cast<std::size_t>(seen[static_cast<std::size_t>(i)])] -
                      of.times.front();
        for (std::size_t k = 0; k < rates.size(); ++k) {
            const Index column = 1 + 2 * static_cast<Index>(k);
            const Eigen::ArrayXd envelope = (rates[k].decay_rate * time).exp();
            const Eigen::ArrayXd phase = two_pi * rates[k].frequency * time;
            basis.functions.col(column) = envelope * phase.cos();
            basis.functions.col(column + 1) = envelope * phase.sin();
            if (!rates[k].is_free)
                continue;
            MatrixXd by_decay(n, 2);
            MatrixXd by_frequency(n, 2);
            by_decay << (time * basis.functions.col(column).array()).matrix(),
                (time * basis.functions.col(column + 1).array()).matrix();
            by_frequency << -two_pi * by_decay.col(1), two_pi * by_decay.col(0);
            basis.by_numbers.push_back(std::move(by_decay));
            basis.by_numbers.push_back(std::move(by_frequency));
            basis.first.insert(basis.first.end(), 2, column);
        }
        return basis;
    }

    void add_height(const HeightHistories& of, std::span<const ModeRate> rates, std::size_t j,
                    const std::vector<Index>& rows) {
        const Basis basis = basis_of(of, rates, rows);
        const auto n = static_cast<Index>(rows.size());
        VectorXd values(n);
        for (Index i = 0; i < n; ++i)
            values[i] =
                of.histories[j][static_cast<std::size_t>(rows[static_cast<std::size_t>(i)])];
        const Eigen::HouseholderQR<MatrixXd> qr(basis.functions);
        const Index columns = basis.functions.cols();
        const auto rest_of = [&](const VectorXd& vector) {
            VectorXd rotated = qr.householderQ().adjoint() * vector;
            rotated.head(columns).setZero();
            return VectorXd(qr.householderQ() * rotated);
        };
        const VectorXd solved = qr.solve(values);
        MatrixXd part(n, std::ssize(basis.by_numbers));
        for (Index k = 0; k < part.cols(); ++k) {
            const auto at = static_cast<std::size_t>(k);
            part.col(k) = rest_of(basis.by_numbers[at] * solved.segment(basis.first[at], 2));
        }
        const Index before = residual.size();
        jacobian.conservativeResize(before + n, part.cols());
        residual.conservativeResize(before + n);
        jacobian.bottomRows(n) = of.weights[j] * part;
        residual.tail(n) = of.weights[j] * rest_of(values);
        coefficients.push_back(solved);
        covariances.emplace_back((basis.functions.transpose() * basis.functions)
                                     .ldlt()
                                     .solve(MatrixXd::Identity(columns, columns)) /
                                 (of.weights[j] * of.weights[j]));
        seen.push_back(rows);
    }
};

std::vector<ModeRate> changed(std::vector<ModeRate> rates, const VectorXd& step) {
    Index at = 0;
    for (ModeRate& rate : rates)
        if (rate.is_free) {
            rate.decay_rate += step[at++];
            rate.frequency += step[at++];
        }
    return rates;
}

bool is_near(const std::vector<ModeRate>& rates, std::span<const ModeRate> starts) {
    return std::ranges::equal(rates, starts, [](const ModeRate& rate, const ModeRate& start) {
        return std::abs(rate.frequency / start.frequency - 1.0) < farthest;
    });
}

/// Covariance of the free numbers.
MatrixXd covariance_of(const Projection& at, std::size_t lags, double freedom) {
    const MatrixXd bread = (at.jacobian.transpose() * at.jacobian)
                               .ldlt()
                               .solve(MatrixXd::Identity(at.jacobian.cols(), at.jacobian.cols()));
    const MatrixXd independent = at.residual.squaredNorm() / freedom * bread;
    const MatrixXd scores = at.jacobian.array().colwise() * at.residual.array();
    const MatrixXd robust = static_cast<double>(scores.rows()) / freedom *
                            (bread * lagged_sum(scores, bartlett_weights(lags)) * bread);
    const VectorXd grown =
        (robust.diagonal().cwiseQuotient(independent.diagonal())).cwiseMax(1.0).cwiseSqrt();
    return grown.asDiagonal() * independent * grown.asDiagonal();
}

DampedModesFit result_of(const HeightHistories& of, const std::vector<ModeRate>& rates,
                         const Projection& at) {
    DampedModesFit fit;
    const Index numbers = at.jacobian.cols();
    const Index linear = (1 + 2 * std::ssize(rates)) * std::ssize(at.coefficients);
    const double freedom =
        std::max(1.0, static_cast<double>(at.residual.size() - numbers - linear));
    const double interval = core::median_interval(of.times);
    const double slowest = std::ranges::min_element(rates, {}, &ModeRate::frequency)->frequency;
    const double lags =
        std::min(1.0 / (slowest * interval), static_cast<double>(of.times.size()) / 5.0);
    const MatrixXd covariance =
        numbers == 0 ? MatrixXd()
                     : covariance_of(at, static_cast<std::size_t>(std::max(lags, 1.0)), freedom);
    fit.weighted_rms = std::sqrt(at.residual.squaredNorm() / freedom);
    fit.samples = static_cast<std::size_t>(at.residual.size());
    Index next = 0;
    for (std::size_t k = 0; k < rates.size(); ++k) {
        DampedMode& mode = fit.modes.emplace_back();
        mode.rate = rates[k];
        const Index column = 1 + 2 * static_cast<Index>(k);
        if (rates[k].is_free) {
            mode.decay_error = std::sqrt(covariance(next, next));
            mode.frequency_error = std::sqrt(covariance(next + 1, next + 1));
            next += 2;
        }
        for (std::size_t j = 0; j < at.coefficients.size(); ++j) {
            mode.amplitudes.emplace_back(at.coefficients[j][column],
                                         -at.coefficients[j][column + 1]);
            mode.amplitude_errors.push_back(
                fit.weighted_rms * std::sqrt(0.5 * (at.covariances[j](column, column) +
                                                    at.covariances[j](column + 1, column + 1))));
        }
    }
    Index row = 0;
    for (std::size_t j = 0; j < at.coefficients.size(); ++j) {
        fit.offsets.push_back(at.coefficients[j][0]);
        std::vector<double>& rest =
            fit.residuals.emplace_back(of.times.size(), std::numeric_limits<double>::quiet_NaN());
        for (const Index i : at.seen[j])
            rest[static_cast<std::size_t>(i)] = at.residual[row++] / of.weights[j];
    }
    return fit;
}

/// The strongest start of a history between two frequencies.
std::optional<RingDownParameters> strongest(const HeightHistories& of, std::size_t j,
                                            double above) {
    RingDownSamples samples;
    for (std::size_t i = 0; i < of.times.size(); ++i)
        if (std::isfinite(of.histories[j][i])) {
            samples.times.push_back(of.times[i] - of.times.front());
            samples.values.push_back(of.histories[j][i]);
        }
    if (samples.times.size() < 12)
        return std::nullopt;
    const double resolved = 0.4 / core::median_interval(samples.times); // above, an alias fits too
    for (const RingDownParameters& start : ring_down_starts(samples, two_pi))
        if (start.frequency > above && start.frequency < resolved)
            return start;
    return std::nullopt;
}

/// The mode above the known ones that stands out most of what these leave, refined together with
/// them; empty if none does.
std::optional<ModeRate> next_mode(const HeightHistories& of, const std::vector<ModeRate>& known) {
    constexpr double least_ratio = 3.0; // f₂/f₁ of a stem is 6.27, with a mass at the tip more
    constexpr double next_ratio = 1.5;  // of higher modes
    constexpr double stands_out = 6.0;  // standard errors of an amplitude
    const auto fit = fit_damped_modes(of, known);
    if (!fit)
        return std::nullopt;
    HeightHistories rest = of;
    rest.histories = fit->residuals;
    const double above = known.back().frequency * (known.size() == 1 ? least_ratio : next_ratio);
    std::optional<ModeRate> found;
    double largest = stands_out;
    for (std::size_t j = 0; j < rest.histories.size(); ++j) {
        const auto start = strongest(rest, j, above);
        if (!start)
            continue;
        std::vector<ModeRate> trial = known;
        trial.push_back({start->decay_rate, start->frequency});
        const auto with = fit_damped_modes(of, trial);
        if (!with || !(with->modes.back().rate.decay_rate < 0.0))
            continue;
        const DampedMode& mode = with->modes.back();
        for (std::size_t h = 0; h < mode.amplitudes.size(); ++h)
            if (const double size = std::abs(mode.amplitudes[h]) / mode.amplitude_errors[h];
                size > largest) {
                largest = size;
                found = mode.rate;
            }
    }
    return found;
}

} // namespace

double DampedMode::damping_ratio() const {
    return -rate.decay_rate / std::hypot(rate.decay_rate, two_pi * rate.frequency);
}

double DampedMode::damping_ratio_error() const {
    return decay_error / (two_pi * rate.frequency);
}

std::size_t DampedMode::largest_height() const {
    std::size_t best = 0;
    const auto size = [&](std::size_t j) { return std::abs(amplitudes[j]) / amplitude_errors[j]; };
    for (std::size_t j = 1; j < amplitudes.size(); ++j)
        if (size(j) > size(best))
            best = j;
    return best;
}

std::optional<DampedModesFit> fit_damped_modes(const HeightHistories& of,
                                               std::span<const ModeRate> starts) {
    std::vector<ModeRate> rates(starts.begin(), starts.end());
    Projection at(of, rates);
    if (at.residual.size() < 4 * (1 + 2 * std::ssize(rates)) * std::ssize(of.histories))
        return std::nullopt;
    double damping = 1e-6;
    bool has_converged = at.jacobian.cols() == 0;
    for (int iteration = 0; iteration < most_iterations && !has_converged; ++iteration) {
        MatrixXd normal = at.jacobian.transpose() * at.jacobian;
        normal.diagonal() *= 1.0 + damping;
        const VectorXd step = normal.ldlt().solve(at.jacobian.transpose() * at.residual);
        if (!step.allFinite())
            return std::nullopt;
        const std::vector<ModeRate> tried = changed(rates, step);
        if (!is_near(tried, starts)) {
            damping = std::max(10.0 * damping, 1e-3);
            if (damping > 1e6)
                return std::nullopt;
            continue;
        }
        Projection next(of, tried);
        const double before = at.residual.squaredNorm();
        const double gain = before - next.residual.squaredNorm();
        if (gain >= 0.0) {
            rates = tried;
            at = std::move(next);
            damping = std::max(0.1 * damping, 1e-9);
            has_converged = gain <= smallest_change * before;
        } else {
            has_converged = -gain <= smallest_change * before;
            damping = std::max(10.0 * damping, 1e-6);
        }
    }
    if (!has_converged)
        return std::nullopt;
    return result_of(of, rates, at);
}

std::vector<ModeRate> visible_modes(const HeightHistories& of, std::size_t count) {
    std::vector<ModeRate> modes;
    std::optional<RingDownFit> best;
    for (std::size_t j = 0; j < of.histories.size(); ++j)
        try {
            RingDownFit found =
                fit_ring_down(of.times, of.histories[j],
                              {.has_offset = true, .has_phase = true, .is_measured = true});
            if (!best || found.r_squared > best->r_squared)
                best = std::move(found);
        } catch (const core::NumericalError&) {
            continue;
        }
    if (!best)
        return modes;
    modes.push_back({best->decay_rate.value, best->frequency.value});
    // Higher modes are largest at the beginning, where few cycles of mode 1 hide how its frequency
    // depends on the amplitude.
    constexpr double early_cycles = 8.0;
    const HeightHistories early =
        part_of(of, of.times.front(), of.times.front() + early_cycles / modes.front().frequency);
    while (modes.size() < count) {
        const auto next = next_mode(early, modes);
        if (!next)
            break;
        modes.push_back(*next);
    }
    return modes;
}

HeightHistories part_of(const HeightHistories& of, double begin, double end) {
    const auto first = std::ranges::lower_bound(of.times, begin) - of.times.begin();
    const auto last = std::ranges::upper_bound(of.times, end) - of.times.begin();
    HeightHistories out;
    out.times.assign(of.times.begin() + first, of.times.begin() + last);
    for (const std::vector<double>& history : of.histories)
        out.histories.emplace_back(history.begin() + first, history.begin() + last);
    out.weights = of.weights;
    return out;
}

} // namespace culm::reduce
