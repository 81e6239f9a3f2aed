// SPDX-License-Identifier: BSD-3-Clause
#include "residuals/residual_structure.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Cholesky>
#include <Eigen/LU>

namespace culm::residuals {
namespace {

constexpr double window_cycles = 2.0;
constexpr std::size_t fewest_structure_frames = 6;

/// Sums for the regression of the swing's residual on the modelled swing and its speed over ω, both
/// about their means over the frames, and a constant. The means are subtracted because the sag of a
/// stem at rest is not an amplitude.
class RateRegression {
  public:
    void add(const Swing& swing, std::size_t i) {
        const double omega = 2.0 * std::numbers::pi * swing.frequency;
        const Eigen::Vector3d basis(swing.modelled[i], swing.modelled_speed[i] / omega, 1.0);
        const double residual = swing.measured[i] - swing.modelled[i];
        sums_ += basis * basis.transpose();
        responses_ += residual * basis;
        squares_ += residual * residual;
        ++frames_;
    }
    /// The constant is orthogonal to the centred columns, so the block of the two is Schur's
    /// complement of its entry and the coupling vanishes.
    [[nodiscard]] Eigen::Matrix3d products() const {
        Eigen::Matrix3d centred = sums_;
        const auto count = static_cast<double>(frames_);
        centred.topLeftCorner<2, 2>() -=
            sums_.topRightCorner<2, 1>() * sums_.bottomLeftCorner<1, 2>() / count;
        centred.topRightCorner<2, 1>().setZero();
        centred.bottomLeftCorner<1, 2>().setZero();
        return centred;
    }
    [[nodiscard]] Eigen::Vector3d solution() const {
        Eigen::Vector3d centred = responses_;
        centred.head<2>() -=
            sums_.topRightCorner<2, 1>() * responses_(2) / static_cast<double>(frames_);
        return products().ldlt().solve(centred);
    }
    [[nodiscard]] bool is_solvable() const {
        return frames_ >= fewest_structure_frames &&
               products().topLeftCorner<2, 2>().determinant() > 0.0;
    }
    [[nodiscard]] double squares() const { return squares_; }
    [[nodiscard]] std::size_t frames() const { return frames_; }

  private:
    Eigen::Matrix3d sums_ = Eigen::Matrix3d::Zero();
    Eigen::Vector3d responses_ = Eigen::Vector3d::Zero();
    double squares_ = 0.0;
    std::size_t frames_ = 0;
};

bool counts(const Swing& swing, std::size_t i) {
    return swing.times[i] >= 0.0 && !std::isnan(swing.measured[i]) &&
           std::isfinite(swing.modelled_speed[i]);
}

/// √2 times the scatter about the mean, less the contribution of noise of that deviation.
class Amplitude {
  public:
    void add(double value) {
        sum_ += value;
        squares_ += value * value;
        count_ += 1.0;
    }
    [[nodiscard]] double over(double noise, double noise_within) const {
        const double scatter = squares_ / count_ - std::pow(sum_ / count_, 2);
        return std::sqrt(2.0 * std::max(scatter - noise_within * noise_within, 0.0)) / noise;
    }

  private:
    double sum_ = 0.0;
    double squares_ = 0.0;
    double count_ = 0.0;
};

/// Amplitude of first-order autoregressive noise at a frequency (Hz), over that of white noise of
/// the same size.
double noise_at(const Swing& swing, double frequency) {
    const double interval = (swing.times.back() - swing.times.front()) /
                            static_cast<double>(std::max<std::size_t>(swing.times.size(), 2) - 1);
    const double correlation = swing.noise_correlation;
    const double phase = 2.0 * std::numbers::pi * frequency * interval;
    return std::sqrt((1.0 - correlation * correlation) /
                     (1.0 - 2.0 * correlation * std::cos(phase) + correlation * correlation));
}

SwingError error_in_third(const Swing& swing, std::size_t third) {
    RateRegression regression;
    Amplitude measured;
    Amplitude modelled;
    for (std::size_t i = 0; i < swing.times.size(); ++i) {
        if (!counts(swing, i) ||
            std::min(static_cast<std::size_t>(3.0 * swing.times[i] / swing.times.back()),
                     std::size_t{2}) != third)
            continue;
        regression.add(swing, i);
        measured.add(swing.measured[i]);
        modelled.add(swing.modelled[i]);
    }
    if (!regression.is_solvable() || !(swing.noise > 0.0))
        return {};
    const Eigen::Vector3d found = regression.solution();
    Eigen::Vector3d errors =
        swing.noise * regression.products().inverse().diagonal().cwiseMax(0.0).cwiseSqrt();
    // Noise that is correlated in time has another power at the swing's frequency and at zero.
    errors.head<2>() *= noise_at(swing, swing.frequency);
    errors(2) *= noise_at(swing, 0.0);
    // The measured swing is (1 + a) cos φ − b sin φ for a modelled cos φ.
    const double ratio = 1.0 + found(0);
    return {std::hypot(ratio, found(1)) - 1.0,
            std::atan2(-found(1), ratio),
            found(2),
            errors(0),
            errors(1),
            errors(2),
            measured.over(swing.noise, swing.noise),
            modelled.over(swing.noise, 0.0)};
}

/// Power of the parts, in units of the swing's noise and summed over the frames.
struct SwingPower {
    double amplitude = 0.0;
    double phase = 0.0;
    double rest = 0.0;
    double all = 0.0;
    double frames = 0.0;
};

SwingPower swing_power(const Swing& swing) {
    SwingPower power;
    std::vector<RateRegression> windows(
        static_cast<std::size_t>(swing.times.back() * swing.frequency / window_cycles) + 1);
    for (std::size_t i = 0; i < swing.times.size(); ++i)
        if (counts(swing, i))
            windows[static_cast<std::size_t>(swing.times[i] * swing.frequency / window_cycles)].add(
                swing, i);
    const double noise = swing.noise * swing.noise;
    for (const RateRegression& window : windows) {
        power.all += window.squares() / noise;
        power.frames += static_cast<double>(window.frames());
        if (!window.is_solvable())
            continue;
        const Eigen::Vector3d found = window.solution();
        const Eigen::Matrix3d products = window.products();
        // Each part takes one degree of freedom from the noise.
        const auto part = [&](int k) {
            return std::max(found(k) * found(k) * products(k, k) / noise - 1.0, 0.0);
        };
        power.amplitude += part(0);
        power.phase += part(1);
        power.rest += part(2);
    }
    return power;
}

} // namespace

ResidualStructure residual_structure(const fit::RecordingFit& fit, const Swing& swing) {
    ResidualStructure structure;
    for (std::size_t third = 0; third < structure.thirds.size(); ++third)
        structure.thirds[third] = error_in_third(swing, third);
    if (!(swing.noise > 0.0))
        return structure;
    double all = 0.0;
    double readings = 0.0;
    for (std::size_t place = 0; place < fit.residuals.size(); ++place) {
        const std::size_t frame = place / fit.prediction.rows;
        if (fit.times[frame] < 0.0 || std::isnan(fit.residuals[place]))
            continue;
        all += std::pow(fit.residuals[place] / fit.noise[place % fit.prediction.rows], 2);
        readings += 1.0;
    }
    structure.excess_over_noise = readings > 0.0 ? all / readings - 1.0 : 0.0;
    const SwingPower power = swing_power(swing);
    const double explained = power.amplitude + power.phase + power.rest;
    const double other_motion = std::max(power.all - power.frames - explained, 0.0);
    const double other_shape = std::max(all - power.all - (readings - power.frames), 0.0);
    const double sum = explained + other_motion + other_shape;
    if (!(sum > 0.0))
        return structure;
    structure.amplitude_share = power.amplitude / sum;
    structure.phase_share = power.phase / sum;
    structure.rest_share = power.rest / sum;
    structure.other_motion_share = other_motion / sum;
    structure.other_shape_share = other_shape / sum;
    return structure;
}

} // namespace culm::residuals
