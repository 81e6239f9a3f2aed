// SPDX-License-Identifier: BSD-3-Clause
// Stiffness and damping of one bond from the stem's parameters.
#pragma once

#include "physics/bond_law_options.hpp"
#include "physics/stem.hpp"

#include <cmath>

namespace culm::physics {

/// Stiffness and damping coefficient of each of the four modes of a bond, and its geometry.
/// Stiffnesses are Eq. 11 of Schramm et al. (2019) times area or second moment, in the right
/// reading K_n = Y/l, K_t = K_n/(2(1+ν)); damping coefficients are the roots of Eqs. 7-10, with the
/// area that Eqs. 7-8 lack (docs/physics.md lists the misprints).
template <class T>
struct BondCoefficients {
    T length;            ///< l, m
    T span;              ///< sum of the spheres' radii, m
    T share_1;           ///< of the span: lever arm of the shear force on the sphere near the clamp
    T share_2;           ///< … on the other sphere
    T normal_stiffness;  ///< k_n = Y A/l, N/m
    T shear_stiffness;   ///< k_t = G A/l, N/m
    T torsion_stiffness; ///< k_tor = G I_p/l, N m
    T bending_stiffness; ///< k_b = Y I/l, N m
    T normal_damping;    ///< 2β √(m_e k_n), N s/m
    T shear_damping;     ///< 2β √(m_e k_t), N s/m
    T torsion_damping;   ///< 2β √(J_e k_tor), N m s
    T bending_damping;   ///< 2β √(J_e k_b), N m s
};

/// Mass and inertia of one sphere.
template <class T>
struct SphereInertia {
    T mass;   ///< kg
    T moment; ///< J, kg m²
};

template <class T>
[[nodiscard]] SphereInertia<T> make_sphere_inertia(const StemParameters<T>& stem) {
    return {stem.sphere_mass(),
            stem.sphere_inertia() + stem.rotary_inertia_share * stem.sphere_mass() *
                                        stem.second_moment_of_area() / stem.section_area()};
}

/// The bond between two equal spheres of `stem` under `law`.
template <class T>
[[nodiscard]] BondCoefficients<T> make_bond_coefficients(const StemParameters<T>& stem,
                                                         const BondLawOptions& law) {
    using std::sqrt;
    // Two equal spheres: the reduced mass m1 m2/(m1+m2) is half of one sphere's.
    const T share = T(law.damping_inertia == DampingInertia::Reduced ? 0.5 : 1.0);
    const T mass = share * stem.sphere_mass();
    const T moment = share * stem.sphere_inertia();
    const T damping = T(law.damping_factor) * stem.bond_damping;

    BondCoefficients<T> bond;
    bond.length = stem.bond_length;
    bond.span = stem.sphere_diameter;
    bond.share_1 = T(0.5);
    bond.share_2 = T(0.5);
    bond.normal_stiffness = stem.bond_youngs_modulus * stem.section_area() / stem.bond_length;
    bond.shear_stiffness =
        stem.shear_modulus() * stem.shear_area_share * stem.section_area() / stem.bond_length;
    bond.torsion_stiffness =
        stem.shear_modulus() * T(2.0) * stem.second_moment_of_area() / stem.bond_length;
    bond.bending_stiffness =
        stem.bond_youngs_modulus * stem.second_moment_of_area() / stem.bond_length;
    bond.normal_damping = damping * sqrt(mass * bond.normal_stiffness);
    bond.shear_damping = damping * sqrt(mass * bond.shear_stiffness);
    bond.torsion_damping = damping * sqrt(moment * bond.torsion_stiffness);
    bond.bending_damping = damping * sqrt(moment * bond.bending_stiffness);
    return bond;
}

} // namespace culm::physics
