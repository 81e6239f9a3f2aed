// SPDX-License-Identifier: BSD-3-Clause
// A power law of resistance that several effects of the air share.
#pragma once

#include "physics/air_drag.hpp"
#include "physics/effects/effect.hpp"

#include <cmath>

namespace culm::physics {

/// r = c (v² + v0²)^((p − 1)/2). For p < 2 the slope of |v|^(p − 1) is infinite at rest, where
/// every stem reverses in each half cycle; v0 makes it finite and changes the force at speed v
/// by the share (p − 1)/2 (v0/v)², 5e-9 at 1 m/s.
struct PowerLaw {
    static constexpr double smoothing_speed = 1e-4; // v0, m/s

    template <class T>
    static Resistance<T> at(const T& coefficient, const T& speed, std::span<const T> shape) {
        using std::pow;
        const T power = shape[0] - T(1.0);
        const T square = speed * speed + T(smoothing_speed * smoothing_speed);
        const T value = coefficient * pow(square, T(0.5) * power);
        return {value, value * power * speed / square};
    }
};

/// The air that moves with the stem.
[[nodiscard]] inline AirMass<double>& moving_air(EffectTarget& target) {
    if (!target.model.air_mass)
        target.model.air_mass = AirMass<double>{0.0, 0.0};
    return *target.model.air_mass;
}

} // namespace culm::physics
