// SPDX-License-Identifier: BSD-3-Clause
// A calibrated stem as input lines of the codes that simulate stems in bulk.
#pragma once

#include "physics/stem.hpp"

#include <string>
#include <vector>

namespace culm::calibrate {

/// What of a calibration a bulk code needs.
struct BulkStem {
    std::string id;
    physics::StemParameters<double> stem; ///< with the calibrated Y and β
    std::string law;                      ///< "schramm2019" or "consistent"
    std::vector<std::string> effects;     ///< beyond the published chain; no bulk code has them
    double reduced_chi_squared = 0.0;
    bool is_adequate = true;
};

/// Lines for LIGGGHTS with the authors' flexible fibres (SI units): `bond_coeff N` with outer and
/// inner diameter as fractions of the particle's, Y, G, damping type 1, β, breakage type 1 and two
/// limits that are never reached. That code is law "schramm2019"; a β of another law would damp
/// 2.27 times too much there, so it is refused (core::InputError).
[[nodiscard]] std::string liggghts_lines(const BulkStem& stem);

/// Lines for LAMMPS with bond style bpm/rotational of its package BPM (units si). Its bond
/// conserves angular momentum, so it is law "consistent"; another is refused (core::InputError).
/// Stiffnesses k_n, k_t, k_tor, k_b are its K_r, K_s, K_t, K_b. Its damping acts on velocities with
/// γ_n = c_n, γ_s = c_t; on the rolling velocity ½γ_r l (ω1 − ω2), so γ_r = 2 c_b/l; on the twist
/// ½γ_t, so γ_t = 2 c_tor; c the coefficients 2β√(inertia × stiffness).
[[nodiscard]] std::string lammps_lines(const BulkStem& stem);

} // namespace culm::calibrate
