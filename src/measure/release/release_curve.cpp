// SPDX-License-Identifier: BSD-3-Clause
#include "measure/release/release_curve.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace culm::measure {

namespace {

/// Roots of cos x cosh x = −1; more modes would add less than 1e-5 of the deflection.
constexpr std::array<double, 8> roots{1.8751040687, 4.6940911330, 7.8547574382, 10.995540735,
                                      14.137168391, 17.278759532, 20.420352251, 23.561944902};

/// Shape of a mode of a clamped-free Euler–Bernoulli beam (Blevins, Formulas for Natural Frequency
/// and Mode Shape, table 8-1), s = x/L; its value at the tip is 2 or −2.
double shape(double root, double s) {
    const double sigma = (std::cosh(root) + std::cos(root)) / (std::sinh(root) + std::sin(root));
    const double x = root * s;
    return std::cosh(x) - std::cos(x) - sigma * (std::sinh(x) - std::sin(x));
}

/// Free motion that starts at 1 at rest; `angle` is the undamped frequency times the time.
double free_motion(double angle, double damping_ratio) {
    // Below, at and above critical damping; near it both formulas lose accuracy.
    const double difference = 1.0 - damping_ratio * damping_ratio;
    const double root = std::sqrt(std::abs(difference));
    if (root < 1e-6)
        return (1.0 + angle) * std::exp(-angle);
    if (difference > 0.0)
        return std::exp(-damping_ratio * angle) *
               (std::cos(root * angle) + damping_ratio / root * std::sin(root * angle));
    const double slow = damping_ratio - root;
    const double fast = damping_ratio + root;
    return (fast * std::exp(-slow * angle) - slow * std::exp(-fast * angle)) / (fast - slow);
}

} // namespace

double ReleaseCurve::at(double time) const {
    if (time <= 0.0)
        return 1.0;
    const double s = std::clamp(relative_height, 0.05, 1.0);
    const double damping = decay_per_cycle / (2.0 * std::numbers::pi);
    // Superposition: the held shape is the static deflection under a force at the tip, the sum of
    // the modes at time zero.
    double sum = 0.0;
    double held = 0.0;
    double tip = 2.0;
    for (const double root : roots) {
        // f ∝ (kL)². A force at the tip deflects a mode in proportion to its value there over its
        // stiffness, which is ∝ (kL)⁴.
        const double ratio = std::pow(root / roots.front(), 2);
        const double share = tip * shape(root, s) / std::pow(root, 4);
        held += share;
        // Stiffness-proportional damping, as in the chain's bonds: the damping ratio grows with the
        // frequency.
        sum += share * free_motion(2.0 * std::numbers::pi * ratio * time / period, damping * ratio);
        // Neighbouring modes have opposite signs at the tip.
        tip = -tip;
    }
    return sum / held;
}

double ReleaseCurve::first_passage() const {
    // Bisection: the first mode crosses zero at a quarter period, which the others shift little.
    double before = 0.05 * period;
    double after = 0.45 * period;
    while (after - before > 1e-4 * period) {
        const double middle = 0.5 * (before + after);
        (at(middle) > 0.0 ? before : after) = middle;
    }
    return before;
}

} // namespace culm::measure
