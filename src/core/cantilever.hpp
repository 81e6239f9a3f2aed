// SPDX-License-Identifier: BSD-3-Clause
// The first frequency of a slender cantilever, by which every stem is judged.
#pragma once

#include <cmath>
#include <numbers>

namespace culm::core {

/// 1.8751²/(2π L²) √(E I/μ), Hz, of the length L, m, the bending rigidity E I, N m², and the mass
/// per length μ, kg/m (Euler and Bernoulli).
[[nodiscard]] inline double cantilever_frequency(double length, double bending_rigidity,
                                                 double mass_per_length) {
    constexpr double root = 1.8751040687119611; // of cos x cosh x = −1
    return root * root / (2.0 * std::numbers::pi * length * length) *
           std::sqrt(bending_rigidity / mass_per_length);
}

} // namespace culm::core
