// SPDX-License-Identifier: BSD-3-Clause
// The Euler-Bernoulli cantilever: mode shapes, frequency equations, integrals.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>

#include <Eigen/Dense>

namespace culm::run {

/// ∫ f(x) dx from 0 to 1 by Simpson's rule.
inline double integral(const std::function<double(double)>& f) {
    constexpr int intervals = 2000;
    double sum = f(0.0) + f(1.0);
    for (int i = 1; i < intervals; ++i)
        sum += (i % 2 == 1 ? 4.0 : 2.0) * f(static_cast<double>(i) / intervals);
    return sum / (3.0 * intervals);
}

/// Root of f between two points of opposite sign.
inline double root(const std::function<double(double)>& f, double low, double high) {
    for (int i = 0; i < 200; ++i) {
        const double middle = 0.5 * (low + high);
        ((f(middle) > 0.0) == (f(low) > 0.0) ? low : high) = middle;
    }
    return low;
}

/// x of the clamped-free modes: cos x cosh x = −1.
inline constexpr double clamped_1 = 1.8751040687119611;
inline constexpr double clamped_2 = 4.694091132974174;

/// A mode of a beam of unit length, free at 1 and held at 0 by a rotational spring of the stiffness
/// `spring` times E I/L (infinite: clamped), scaled to 1 at the tip.
class BeamMode {
  public:
    explicit BeamMode(double x = clamped_1, double spring = INFINITY) : x_(x), spring_(spring) {
        // w = a (cos − cosh) + b sin + c sinh with w(0) = 0, w''(0) = spring w'(0), w''(1) = 0.
        const double slope = std::isinf(spring) ? 0.0 : -2.0 * x / spring; // (b + c)/a
        const double sine = std::sin(x);
        const double sinh = std::sinh(x);
        // −a (cos + cosh) − b sin + c sinh = 0 with c = slope − b.
        b_ = (slope * sinh - (std::cos(x) + std::cosh(x))) / (sine + sinh);
        c_ = slope - b_;
        scale_ = 1.0;
        scale_ = 1.0 / value(1.0);
    }
    [[nodiscard]] double value(double s) const {
        return scale_ * (std::cos(x_ * s) - std::cosh(x_ * s) + b_ * std::sin(x_ * s) +
                         c_ * std::sinh(x_ * s));
    }
    [[nodiscard]] double slope(double s) const {
        return scale_ * x_ *
               (-std::sin(x_ * s) - std::sinh(x_ * s) + b_ * std::cos(x_ * s) +
                c_ * std::cosh(x_ * s));
    }
    [[nodiscard]] double curvature(double s) const {
        return scale_ * x_ * x_ *
               (-std::cos(x_ * s) - std::cosh(x_ * s) - b_ * std::sin(x_ * s) +
                c_ * std::sinh(x_ * s));
    }

  private:
    double x_;
    double spring_;
    double b_ = 0.0;
    double c_ = 0.0;
    double scale_ = 1.0;
};

/// First frequency of a clamped beam whose stiffness and mass vary along it, over that of the
/// uniform one: Rayleigh-Ritz with the polynomials s² … s⁹.
inline double frequency_ratio(const std::function<double(double)>& stiffness,
                              const std::function<double(double)>& mass) {
    constexpr int count = 8;
    Eigen::Matrix<double, count, count> k;
    Eigen::Matrix<double, count, count> m;
    for (int i = 0; i < count; ++i)
        for (int j = 0; j < count; ++j) {
            const double p = i + 2;
            const double q = j + 2;
            k(i, j) = integral([&](double s) {
                return stiffness(s) * p * (p - 1) * q * (q - 1) * std::pow(s, p + q - 4);
            });
            m(i, j) = integral([&](double s) { return mass(s) * std::pow(s, p + q); });
        }
    const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::Matrix<double, count, count>> modes(k, m);
    return std::sqrt(modes.eigenvalues()[0]) / (clamped_1 * clamped_1);
}

} // namespace culm::run
