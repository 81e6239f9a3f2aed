// SPDX-License-Identifier: BSD-3-Clause
// A calibrated stem as input lines of the codes that simulate stems in bulk.
#pragma once

#include "physics/effects/effect.hpp"
#include "physics/stem.hpp"

#include <map>
#include <span>
#include <string>
#include <vector>

namespace culm::calibrate {

/// An effect as a calibration file stores it; a user's effect file is no longer needed.
struct StoredEffect {
    std::string name;
    std::map<std::string, double> values; ///< by the parameter's name
};

/// The data of a calibration that a bulk code needs.
struct BulkStem {
    std::string id;
    physics::StemParameters<double> stem; ///< with the calibrated Y and β
    std::string law;                      ///< "schramm2019" or "consistent"
    std::vector<physics::AttachedMass> added_masses;
    std::vector<StoredEffect> effects; ///< beyond the published chain
    std::vector<std::string> left_out; ///< names of what the user left out
    double reduced_chi_squared = 0.0;
    bool is_adequate = true;
};

/// Takes the effects of these names out of every stem that has them; "added_mass" means the
/// known masses. Throws core::InputError for a name that no stem has.
void leave_out(std::span<BulkStem> stems, std::span<const std::string> names);

// Both codes get a sphere's own mass as its density, because its diameter must stay: a mass at
// height h is shared by the two nearest spheres as in the calibrated chain (physics::add_mass). The
// effect tip_mass is such a mass, and gravity is a fix. Any other effect has no line in these codes
// and is refused (core::InputError).

/// Of LAMMPS: how it reads bond_style bpm/rotational.
enum class LammpsVersion { UpTo30March2026, From4July2026 };

/// Numbers of the next types of atoms and bonds in an input that several stems share.
struct TypeNumbers {
    int atom = 1;
    int bond = 1;
};

/// Lines for LIGGGHTS with the authors' flexible fibres (SI units): `bond_coeff N` with outer and
/// inner diameter as fractions of the particle's, Y, G, damping type 1, β, breakage type 1 and two
/// limits that are never reached. That code is law "schramm2019"; a β of another law would damp
/// 2.27 times too much there, so it is refused (core::InputError). It uses the reduced mass of a
/// bond's own two spheres, the calibrated chain that of two whole ones: bonds next to another mass
/// have their own types with β √(m (m_i + m_j)/(2 m_i m_j)).
[[nodiscard]] std::string liggghts_lines(const BulkStem& stem, TypeNumbers& next);

/// Lines for LAMMPS with bond style bpm/rotational of its package BPM (units si). Its bond
/// conserves angular momentum, so it is law "consistent"; another is refused (core::InputError).
/// Stiffnesses k_n, k_t, k_tor, k_b are its K_r, K_s, K_t, K_b. Its damping acts on velocities with
/// γ_n = c_n, γ_s = c_t; on the rolling velocity ½γ_r l (ω1 − ω2), so γ_r = 2 c_b/l; on the twist
/// ½γ_t, so γ_t = 2 c_tor; c the coefficients 2β√(inertia × stiffness).
///
/// From version 4 July 2026 on, the style has a different default damping, and its factors three
/// and four are exchanged. The lines select the former damping, which is the chain's.
[[nodiscard]] std::string lammps_lines(const BulkStem& stem, LammpsVersion version,
                                       TypeNumbers& next);

} // namespace culm::calibrate
