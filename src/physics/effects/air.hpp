// SPDX-License-Identifier: BSD-3-Clause
// What the effects of the air share: a power law of resistance, and the air around a stem that
// swings little.
#pragma once

#include "physics/air_drag.hpp"
#include "physics/effects/effect.hpp"

#include <cmath>
#include <complex>
#include <span>

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

struct AirProperties {
    double density = air_density;        ///< kg/m³
    double kinematic_viscosity = 1.5e-5; ///< m²/s, of air at 20 °C
};

/// Mass and resistance that still air adds to a stem.
struct StillAir {
    double mass_per_length = 0.0;       ///< kg/m
    double resistance_per_length = 0.0; ///< force over speed, N s/m²
};

/// Γ of a cylinder or of a thin plate across the flow. A cylinder of width W that swings with ω in
/// a viscous fluid feels the force ¼πρW² Γ ω² x per length (Stokes 1851; Sader 1998), Γ = 1 + 4i
/// K₁(z)/(√(iRe) K₀(z)), z = −i √(iRe), Re = ωW²/4ν, for a motion ~ exp(−iωt). The real part of Γ
/// is an added mass, the imaginary one a loss. Trap: Sader's Re contains half the width.
[[nodiscard]] std::complex<double> hydrodynamic_function(double reynolds_number, bool is_plate);

/// The air of a stem that swings with this angular frequency, rad/s.
[[nodiscard]] StillAir still_air_of(const StemParameters<double>& stem, double angular_frequency,
                                    const AirProperties& air = {});

} // namespace culm::physics
