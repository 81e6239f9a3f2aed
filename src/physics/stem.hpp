// SPDX-License-Identifier: BSD-3-Clause
// The stem as a chain of equal bonded spheres: geometry, material, and the section of its bonds.
#pragma once

#include <numbers>
#include <optional>

namespace culm::physics {

/// Everything that distinguishes one stem from another; SI units. The defaults are Table 1 of
/// Schramm et al. (2019). T may be a double, SIMD lanes (one stem per lane) or a dual number.
template <class T>
struct StemParameters {
    int sphere_count = 56;                  ///< spheres in the chain, the clamped one included
    T sphere_diameter = T(2.83e-3);         ///< m
    T bond_length = T(2.83e-3);             ///< equilibrium distance of neighbouring centres, m
    T bond_outer_diameter = T(2.83e-3);     ///< m
    T bond_inner_diameter = T(0.0);         ///< m; 0 for a solid section
    T density = T(125.0);                   ///< of the spheres, kg/m³
    T poissons_ratio = T(0.3);              ///< gives the shear modulus Y/(2(1+ν))
    T bond_youngs_modulus = T(1.0e9);       ///< Y, Pa
    T bond_damping = T(25.0);               ///< β, dimensionless
    T axial_acceleration_of_gravity = T(0); ///< m/s², positive away from the clamp
    /// Mass and moment of inertia of the last sphere over those of the others: 1 in the published
    /// chain; 0.5 if the stem ends at its centre.
    T tip_mass_share = T(1.0);
    /// Width of the section across the plane of motion, m, which the air resists; empty: the outer
    /// diameter, as of a round stem. Bending knows only the diameters of the bonds.
    std::optional<T> width_across_motion = {};
    /// Depth of a rectangular section in the plane of motion, m; empty: the section is round. Air
    /// separates at the edges of a rectangle, and strains are those of this depth.
    std::optional<T> rectangle_depth = {};
    /// Area that resists shear over section_area(): 1 in the published chain; Timoshenko's
    /// correction for a stem with a section.
    T shear_area_share = T(1.0);
    /// Share of the section's rotary inertia m I/A that the spheres have in addition to their own:
    /// 0 in the published chain.
    T rotary_inertia_share = T(0.0);

    /// Distance from the clamped centre to the tip's centre, m.
    [[nodiscard]] T free_length() const { return bond_length * T(double(sphere_count - 1)); }
    /// Width that the air resists, m.
    [[nodiscard]] T width_in_air() const {
        return width_across_motion.value_or(bond_outer_diameter);
    }
    /// From the neutral axis to the outermost fibre, m.
    [[nodiscard]] T outer_fibre() const {
        return T(0.5) * rectangle_depth.value_or(bond_outer_diameter);
    }
    /// Mass of one sphere, kg.
    [[nodiscard]] T sphere_mass() const {
        return density * T(std::numbers::pi / 6.0) * sphere_diameter * sphere_diameter *
               sphere_diameter;
    }
    /// Moment of inertia of one sphere, J = 2/5 m R², kg m².
    [[nodiscard]] T sphere_inertia() const {
        return T(0.1) * sphere_mass() * sphere_diameter * sphere_diameter;
    }
    /// A = π(d_o² − d_i²)/4, m².
    [[nodiscard]] T section_area() const {
        return T(std::numbers::pi / 4.0) * (bond_outer_diameter * bond_outer_diameter -
                                            bond_inner_diameter * bond_inner_diameter);
    }
    /// I = π(d_o⁴ − d_i⁴)/64, m⁴; the polar moment is twice that.
    [[nodiscard]] T second_moment_of_area() const {
        const T outer = bond_outer_diameter * bond_outer_diameter;
        const T inner = bond_inner_diameter * bond_inner_diameter;
        return T(std::numbers::pi / 64.0) * (outer * outer - inner * inner);
    }
    /// G = Y/(2(1+ν)), Pa.
    [[nodiscard]] T shear_modulus() const {
        return bond_youngs_modulus / (T(2.0) * (T(1.0) + poissons_ratio));
    }
};

} // namespace culm::physics
