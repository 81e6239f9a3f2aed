// SPDX-License-Identifier: BSD-3-Clause
// The air around a stem that swings little: added mass and viscous loss, both without a free size.
#include "physics/effects/air.hpp"
#include "physics/effects/stem_scales.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace culm::physics {

namespace {

using Complex = std::complex<double>;

struct BesselPair {
    Complex zeroth; ///< e^z K_0(z)
    Complex first;  ///< e^z K_1(z)
};

/// K_n(z) = ∫ exp(−z cosh t) cosh nt dt by trapezoids, whose error falls exponentially with their
/// number because the integrand is smooth and even; Re z > 0.
BesselPair modified_bessel(const Complex& z) {
    constexpr int intervals = 400;
    const double end = std::acosh(1.0 + 40.0 / z.real());
    const double step = end / intervals;
    BesselPair sums{0.5, 0.5};
    for (int k = 1; k <= intervals; ++k) {
        const double cosine = std::cosh(step * k);
        const Complex value = std::exp(-z * (cosine - 1.0));
        sums.zeroth += value;
        sums.first += cosine * value;
    }
    return {step * sums.zeroth, step * sums.first};
}

double polynomial(double x, std::initializer_list<double> coefficients) {
    double sum = 0.0;
    double power = 1.0;
    for (const double coefficient : coefficients) {
        sum += coefficient * power;
        power *= x;
    }
    return sum;
}

/// Ratio of a thin plate's function to that of a cylinder of its width; Sader (1998) fitted it for
/// Reynolds numbers from 1e-6 to 1e4.
Complex plate_over_cylinder(double reynolds_number) {
    const double x = std::log10(std::clamp(reynolds_number, 1e-6, 1e4));
    return {
        polynomial(x, {0.91324, -0.48274, 0.46842, -0.12886, 0.044055, -0.0035117, 0.00069085}) /
            polynomial(x, {1.0, -0.56964, 0.48690, -0.13444, 0.045155, -0.0035862, 0.00069085}),
        polynomial(x, {-0.024134, -0.029256, 0.016294, -0.00010961, 0.000064577, -0.000044510}) /
            polynomial(x, {1.0, -0.59702, 0.55182, -0.18357, 0.079156, -0.014369, 0.0028361})};
}

EffectParameter known(const char* name, const char* unit, const char* meaning, double value) {
    EffectParameter parameter = size_parameter(
        name, unit, meaning,
        {.default_value = value, .lower = 0.0, .upper = 1e3 * value, .scale = value});
    parameter.calibrated = false;
    return parameter;
}

} // namespace

Complex hydrodynamic_function(double reynolds_number, bool is_plate) {
    const Complex root = std::sqrt(Complex(0.0, reynolds_number));
    const BesselPair bessel = modified_bessel(Complex(0.0, -1.0) * root);
    const Complex cylinder = 1.0 + Complex(0.0, 4.0) * bessel.first / (root * bessel.zeroth);
    return is_plate ? plate_over_cylinder(reynolds_number) * cylinder : cylinder;
}

StillAir still_air_of(const StemParameters<double>& stem, double angular_frequency,
                      const AirProperties& air) {
    const double width = stem.width_in_air();
    const double reynolds_number =
        0.25 * angular_frequency * width * width / air.kinematic_viscosity;
    const double displaced = 0.25 * std::numbers::pi * air.density * width * width;
    const Complex function =
        hydrodynamic_function(reynolds_number, stem.rectangle_depth.has_value());
    return {displaced * function.real(), displaced * angular_frequency * function.imag()};
}

EffectPointer still_air() {
    return make_effect(
        {.name = "still_air",
         .family = Family::Air,
         .summary = "added mass and viscous loss of the air around a stem that swings little",
         .law = "mass per length ¼πρW² Re Γ and force per length -¼πρW² ω Im Γ v sideways, with "
                "the hydrodynamic function Γ(ωW²/4ν) of a cylinder, or of a thin plate if the "
                "section is a rectangle; W is the width across the motion and ω that of mode 1",
         .source = "Stokes (1851), Trans. Camb. Phil. Soc. 9:8-106 (cylinder); Sader (1998), J. "
                   "Appl. Phys. 84:64-76 (plate)",
         .signature = "all frequencies fall by half the added share of mass, 0.6 % for a straw, "
                      "which a lower modulus does too; a linear decay at every amplitude",
         .remedy = "nothing is fitted: name it in the calibration, and Y is that of the stem in "
                   "vacuum",
         .energy = "stores ½ m_a v² and takes out c v² per length and second",
         .parameters = {known("density_kg_m3", "kg/m³", "ρ: density of the air", air_density),
                        known("viscosity_m2_s", "m²/s", "ν: kinematic viscosity of the air",
                              AirProperties{}.kinematic_viscosity)},
         .belongs_to = BelongsTo::Rig,
         .revealed_by = {{"release in a vacuum", {1e-3, 1.0}}}},
        [](std::span<const double> values, EffectTarget& target) {
            const StillAir air = still_air_of(target.stem, loaded_angular_frequency(target),
                                              {values[0], std::max(values[1], 1e-9)});
            moving_air(target).constant += air.mass_per_length;
            target.model.air.push_back({.law = &resistance_law<PowerLaw>,
                                        .coefficient = air.resistance_per_length,
                                        .shape = {1.0}});
        });
}

} // namespace culm::physics
