// SPDX-License-Identifier: BSD-3-Clause
#include "measure/release/release_curve.hpp"

#include "core/cantilever.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace culm::measure {

namespace {

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
    // the modes at time zero; more than these eight would add less than 1e-5 of it.
    double sum = 0.0;
    double held = 0.0;
    for (std::size_t mode = 0; mode < core::cantilever_roots.size(); ++mode) {
        // f ∝ (kL)². A force at the tip deflects a mode, which is 1 there, in proportion to 1 over
        // its stiffness, which is ∝ (kL)⁴.
        const double ratio = std::pow(core::cantilever_roots[mode] / core::cantilever_roots[0], 2);
        const double share = core::cantilever_shape(mode, s).value / std::pow(ratio, 2);
        held += share;
        // Stiffness-proportional damping, as in the chain's bonds: the damping ratio grows with the
        // frequency.
        sum += share * free_motion(2.0 * std::numbers::pi * ratio * time / period, damping * ratio);
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
