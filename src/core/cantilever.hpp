// SPDX-License-Identifier: BSD-3-Clause
// The modes of a slender cantilever, by which every stem is judged.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>

namespace culm::core {

/// Roots of cos x cosh x = −1, of modes 1 to 8.
inline constexpr std::array cantilever_roots{
    1.8751040687119611, 4.694091132974174,  7.854757438237613, 10.995540734875467,
    14.13716839104647,  17.278759532088237, 20.42035225104125, 23.561944901806445};

/// 1.8751²/(2π L²) √(E I/μ), Hz, of the length L, m, the bending rigidity E I, N m², and the mass
/// per length μ, kg/m (Euler and Bernoulli).
[[nodiscard]] inline double cantilever_frequency(double length, double bending_rigidity,
                                                 double mass_per_length) {
    constexpr double root = cantilever_roots.front();
    return root * root / (2.0 * std::numbers::pi * length * length) *
           std::sqrt(bending_rigidity / mass_per_length);
}

/// Shape of mode number `mode` (0 … 7) at the place x (0 … 1) along the stem, 1 at the tip, and its
/// derivatives by x.
struct ModeShape {
    double value = 0.0;
    double slope = 0.0;
    double curvature = 0.0;
};
[[nodiscard]] inline ModeShape cantilever_shape(std::size_t mode, double x) {
    const double root = cantilever_roots[mode];
    const double ratio = (std::cosh(root) + std::cos(root)) / (std::sinh(root) + std::sin(root));
    const auto at = [&](double z) {
        return ModeShape{std::cosh(z) - std::cos(z) - ratio * (std::sinh(z) - std::sin(z)),
                         root * (std::sinh(z) + std::sin(z) - ratio * (std::cosh(z) - std::cos(z))),
                         root * root *
                             (std::cosh(z) + std::cos(z) - ratio * (std::sinh(z) + std::sin(z)))};
    };
    const double tip = at(root).value;
    const ModeShape here = at(root * x);
    return {here.value / tip, here.slope / tip, here.curvature / tip};
}

} // namespace culm::core
