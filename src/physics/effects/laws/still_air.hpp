// SPDX-License-Identifier: BSD-3-Clause
// What the air around a stem adds to it in a swing of small amplitude.
//
// A cylinder of width W that swings with ω in a viscous fluid feels the force ¼πρW² Γ ω² x per
// length (Stokes 1851; Sader 1998), Γ = 1 + 4i K₁(z)/(√(iRe) K₀(z)), z = −i √(iRe),
// Re = ωW²/4ν, for a motion ~ exp(−iωt). The real part of Γ is an added mass, the imaginary one a
// loss. Trap: Sader's Re contains half the width.
#pragma once

#include "physics/air_drag.hpp"
#include "physics/stem.hpp"

#include <complex>

namespace culm::physics {

struct AirProperties {
    double density = air_density;        ///< kg/m³
    double kinematic_viscosity = 1.5e-5; ///< m²/s, of air at 20 °C
};

struct StillAir {
    double mass_per_length = 0.0;       ///< kg/m
    double resistance_per_length = 0.0; ///< force over speed, N s/m²
};

/// Γ of a cylinder or of a thin plate across the flow.
[[nodiscard]] std::complex<double> hydrodynamic_function(double reynolds_number, bool is_plate);

/// The air of a stem that swings with this angular frequency, rad/s.
[[nodiscard]] StillAir still_air_of(const StemParameters<double>& stem, double angular_frequency,
                                    const AirProperties& air = {});

} // namespace culm::physics
