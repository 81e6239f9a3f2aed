// SPDX-License-Identifier: BSD-3-Clause
// Forces with which the surroundings resist the motion of the stem, and the air that moves with it.
// The effect files define the laws; this file evaluates them for the chain.
#pragma once

#include "core/lanes.hpp"
#include "core/vec.hpp"

#include <array>
#include <cmath>
#include <concepts>
#include <span>
#include <stdexcept>
#include <vector>

namespace culm::physics {

using core::Vec;

inline constexpr double air_density = 1.2; ///< kg/m³, 20 °C at sea level

/// Force on a sphere and its derivatives.
template <int Dim, class T>
struct NodeLoad {
    Vec<Dim, T> force = Vec<Dim, T>::zero(); ///< N
    /// ∂force/∂velocity, one vector a component of the velocity, N s/m
    std::array<Vec<Dim, T>, static_cast<std::size_t>(Dim)> by_velocity{};
    T by_deflection = T(0.0); ///< ∂force/∂position, both sideways, N/m
};

/// The factor r of the force −r(|v|) v.
template <class T>
struct Resistance {
    T value;    ///< r, N s/m
    T by_speed; ///< dr/d|v|, N s²/m²
};

/// A law of resistance. It is proportional to a coefficient, which the chain multiplies by the
/// length of stem that a sphere represents; `shape` contains the other parameters of the law. There
/// is one function for each scalar type of a chain, so the loop over the spheres needs no look-up.
struct ResistanceLaw {
    template <class T>
    using Function = Resistance<T> (*)(const T& coefficient, const T& speed,
                                       std::span<const T> shape);
    Function<double> of_one;
    Function<core::Lanes> of_lanes;

    template <class T>
    [[nodiscard]] Resistance<T> operator()(const T& coefficient, const T& speed,
                                           std::span<const T> shape) const {
        if constexpr (std::same_as<T, double>)
            return of_one(coefficient, speed, shape);
        else if constexpr (std::same_as<T, core::Lanes>)
            return of_lanes(coefficient, speed, shape);
        else
            throw std::logic_error("laws of resistance are for doubles and lanes");
    }
};

/// The law that a type defines by a static member template `at`, with the arguments above.
template <class Law>
inline constexpr ResistanceLaw resistance_law{&Law::template at<double>,
                                              &Law::template at<core::Lanes>};

/// One law with its parameters, which are the same along the whole stem.
template <class T>
struct AirDrag {
    const ResistanceLaw* law;
    T coefficient; ///< per length
    std::vector<T> shape = {};
};

/// Air that moves with the stem sideways. Its mass per length at the sideways speed u is
///     μ(u) = constant + growing (u² + u0²)^(1/3),
/// so the force on the stem is −d/dt ∫ μ du and conserves the kinetic energy ∫ μ u du. u0 makes the
/// slope finite at rest, where every stem reverses twice a cycle.
template <class T>
struct AirMass {
    T constant;                 ///< kg/m
    T growing;                  ///< kg/m at 1 m/s
    T smallest_speed = T(1e-9); ///< u0, m/s
};

/// The air at one sphere.
template <class T>
struct MovedAir {
    T mass = T(0.0);  ///< μ times the length of stem, kg
    T slope = T(0.0); ///< dμ/du = slope · u, kg s²/m²
};

template <class T>
[[nodiscard]] MovedAir<T> moved_air(const AirMass<T>& air, const T& length,
                                    const T& squared_speed) {
    using std::pow;
    const T sum = squared_speed + air.smallest_speed * air.smallest_speed;
    const T growing = length * air.growing * pow(sum, T(1.0 / 3.0));
    return {length * air.constant + growing, T(2.0 / 3.0) * growing / sum};
}

/// ∫ μ u du times the length of stem, J.
template <class T>
[[nodiscard]] T moved_air_energy(const AirMass<T>& air, const T& length, const T& squared_speed) {
    using std::pow;
    const T smallest = air.smallest_speed * air.smallest_speed;
    const T growth = pow(squared_speed + smallest, T(4.0 / 3.0)) - pow(smallest, T(4.0 / 3.0));
    return length * (T(0.5) * air.constant * squared_speed + T(0.375) * air.growing * growth);
}

/// Adds −r v and its derivative −r 1 − r' v vᵀ/|v| for `length` of stem; r is the sum of the laws'.
template <int Dim, class T>
void add_air_drag(std::span<const AirDrag<T>> drags, const T& length, const Vec<Dim, T>& velocity,
                  NodeLoad<Dim, T>& load) {
    using std::sqrt;
    // Far below any speed that a camera resolves; keeps the derivative of the root finite at rest.
    const T floor = T(1e-18);
    const T speed = sqrt(dot(velocity, velocity) + floor);
    Resistance<T> sum{T(0.0), T(0.0)};
    for (const AirDrag<T>& drag : drags) {
        const Resistance<T> of =
            (*drag.law)(drag.coefficient * length, speed, std::span<const T>(drag.shape));
        sum = {sum.value + of.value, sum.by_speed + of.by_speed};
    }
    load.force -= sum.value * velocity;
    for (int k = 0; k < Dim; ++k) {
        auto& column = load.by_velocity[static_cast<std::size_t>(k)];
        column -= (sum.by_speed * velocity[k] / speed) * velocity;
        column[k] = column[k] - sum.value;
    }
}

} // namespace culm::physics
