// SPDX-License-Identifier: BSD-3-Clause
#include "calibrate/bulk_export.hpp"

#include "core/error.hpp"
#include "physics/bond_coefficients.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

namespace culm::calibrate {
namespace {

void require_law(const BulkStem& bulk, const char* law, const char* code) {
    if (bulk.law != law)
        throw core::InputError(
            fmt::format("{}: calibrated under law \"{}\", but {} has law \"{}\", which damps "
                        "differently at the same beta; calibrate with --law {}",
                        bulk.id, bulk.law, code, law, law));
}

/// What the lines are about, and what the bulk code will lack; comments of either language.
std::string heading(const BulkStem& bulk, const char* code) {
    const physics::StemParameters<double>& stem = bulk.stem;
    std::string text = fmt::format(
        "# {}: stem {} as calibrated by culm, law {}, SI units (m, kg, s, N, Pa)\n"
        "# Y = {:.9g} Pa, beta = {:.9g}, Poisson's ratio {:.6g}\n"
        "# {} spheres, centres {:.9g} m apart, the first one clamped; beta belongs to this "
        "spacing\n",
        code, bulk.id, bulk.law, stem.bond_youngs_modulus, stem.bond_damping, stem.poissons_ratio,
        stem.sphere_count, stem.bond_length);
    if (!bulk.is_adequate)
        text += fmt::format("# CAUTION: the chain leaves more than noise (reduced chi2 {:.4g}): "
                            "something is missing in this model\n",
                            bulk.reduced_chi_squared);
    for (const std::string& effect : bulk.effects)
        text += fmt::format("# CAUTION: calibrated together with {}, which these lines do not "
                            "contain\n",
                            effect);
    return text;
}

/// The tip stands for half a bond length of stem; its moment of inertia is halved along with its
/// mass.
std::string tip_note(const BulkStem& bulk, const char* command) {
    if (bulk.stem.tip_mass_share == 1.0)
        return {};
    return fmt::format("# the last sphere of each stem carries {:.6g} of that mass (group \"tips\" "
                       "is yours to define):\n{}",
                       bulk.stem.tip_mass_share, command);
}

} // namespace

std::string liggghts_lines(const BulkStem& bulk) {
    require_law(bulk, "schramm2019", "the authors' code");
    const physics::StemParameters<double>& stem = bulk.stem;
    const double stiffness = stem.bond_youngs_modulus * std::numbers::pi *
                             stem.bond_outer_diameter * stem.bond_outer_diameter /
                             (4.0 * stem.bond_length);
    const double step =
        0.95 / ((1.1 + 2.9 * stem.bond_damping) * std::sqrt(stiffness / stem.sphere_mass()));
    std::string text = heading(bulk, "LIGGGHTS with flexible fibres");
    text += fmt::format("set type 1 diameter {:.9g} density {:.9g}\n", stem.sphere_diameter,
                        stem.density);
    text += tip_note(
        bulk,
        fmt::format("set group tips density {:.9g}\n", stem.tip_mass_share * stem.density).c_str());
    text += "# bond type, outer and inner diameter over the sphere's, Y, G, damping type, beta, "
            "breakage type, critical normal and shear stress\n";
    text += fmt::format("bond_coeff 1 {:.9g} {:.9g} {:.9g} {:.9g} 1 {:.9g} 1 1.0e32 1.0e32\n",
                        stem.bond_outer_diameter / stem.sphere_diameter,
                        stem.bond_inner_diameter / stem.sphere_diameter, stem.bond_youngs_modulus,
                        stem.shear_modulus(), stem.bond_damping);
    text += fmt::format("# largest step by that code's own rule: {:.4g} s\n", step);
    return text;
}

std::string lammps_lines(const BulkStem& bulk) {
    require_law(bulk, "consistent", "LAMMPS's bpm/rotational");
    const physics::StemParameters<double>& stem = bulk.stem;
    const auto bond = physics::make_bond_coefficients(stem, physics::consistent_law());
    std::string text = heading(bulk, "LAMMPS, package BPM");
    text += "# not carried over: bonds follow the spheres' orientations instead of rates (the same "
            "for small relative rotations of\n# neighbours); contacts and breakage are yours to "
            "set. Damping is that of two whole spheres in every bond.\n";
    text += "units si\natom_style bpm/sphere\nnewton on off\ncomm_modify vel yes\n"
            "special_bonds lj 0 1 1 coul 1 1 1\n"
            "bond_style bpm/rotational break no smooth no\n";
    text += fmt::format("set type 1 diameter {:.9g} density {:.9g}\n", stem.sphere_diameter,
                        stem.density);
    text += tip_note(
        bulk,
        fmt::format("set group tips density {:.9g}\n", stem.tip_mass_share * stem.density).c_str());
    text += "# bond type, K_r N/m, K_s N/m, K_t N m, K_b N m, four critical loads that are never "
            "reached (the first also sets how far\n# bonds may stretch: by their length), gamma_n "
            "N s/m, gamma_s N s/m, gamma_r N s, gamma_t N m s\n";
    text += fmt::format(
        "bond_coeff 1 {:.9g} {:.9g} {:.9g} {:.9g} {:.9g} 1.0e32 1.0e32 1.0e32 {:.9g} {:.9g} "
        "{:.9g} {:.9g}\n",
        bond.normal_stiffness, bond.shear_stiffness, bond.torsion_stiffness, bond.bending_stiffness,
        bond.normal_stiffness * bond.length, bond.normal_damping, bond.shear_damping,
        2.0 * bond.bending_damping / bond.length, 2.0 * bond.torsion_damping);
    text += "fix motion all nve/bpm/sphere\n";
    return text;
}

} // namespace culm::calibrate
