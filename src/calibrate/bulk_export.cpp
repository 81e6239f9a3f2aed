// SPDX-License-Identifier: BSD-3-Clause
#include "calibrate/bulk_export.hpp"

#include "core/error.hpp"
#include "core/nearest_name.hpp"
#include "physics/bond_coefficients.hpp"
#include "run/case_model.hpp"
#include "run/simulate.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace culm::calibrate {
namespace {

/// Throws core::InputError if the stem would not vibrate in the code as it was calibrated: under
/// another law, or without an effect that has no input line.
void require_exportable(const BulkStem& bulk, const char* law, const char* code) {
    if (bulk.law != law)
        throw core::InputError(
            fmt::format("{}: calibrated under law \"{}\", but {} has law \"{}\", which damps "
                        "differently at the same beta; calibrate with --law {}",
                        bulk.id, bulk.law, code, law, law));
    std::vector<std::string> unknown;
    for (const StoredEffect& effect : bulk.effects)
        if (effect.name != "tip_mass" && effect.name != "gravity")
            unknown.push_back(effect.name);
    if (!unknown.empty())
        throw core::InputError(fmt::format(
            "{}: calibrated with {}, for which {} has no input line; the exported stem would not "
            "vibrate as calibrated. To leave it out: --without {}",
            bulk.id, fmt::join(unknown, ", "), code, fmt::join(unknown, ",")));
}

/// A summary of the calibration and of the effects left out, as comments of either language.
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
        text += fmt::format("# CAUTION: model inadequate (reduced chi2 {:.4g}): its residuals are "
                            "not noise\n",
                            bulk.reduced_chi_squared);
    for (const std::string& name : bulk.left_out)
        text += fmt::format("# CAUTION: calibrated with {}, which --without left out\n", name);
    return text;
}

/// Mass of every sphere, kg: the same sums as in the chain that was fitted.
std::vector<double> sphere_masses(const BulkStem& bulk) {
    run::CaseSpec spec;
    spec.stem = bulk.stem;
    spec.added_masses = bulk.added_masses;
    for (const StoredEffect& effect : bulk.effects)
        if (effect.name == "tip_mass")
            spec.added_masses.push_back({bulk.stem.free_length(), effect.values.at("mass_kg")});
    const auto spheres = run::case_model(spec).chain.spheres;
    std::vector<double> masses(static_cast<std::size_t>(bulk.stem.sphere_count),
                               spheres.front().mass);
    if (spheres.size() > 1)
        std::ranges::transform(spheres, masses.begin(), [](const auto& s) { return s.mass; });
    return masses;
}

/// Diameter and density of the spheres, and the densities of those that carry another mass: the
/// tip, which represents half a bond length of stem, and spheres with an added mass.
std::string sphere_lines(const BulkStem& bulk, const std::vector<double>& masses, int type) {
    const physics::StemParameters<double>& stem = bulk.stem;
    std::string text = fmt::format("set type {} diameter {:.9g} density {:.9g}\n", type,
                                   stem.sphere_diameter, stem.density);
    const double plain = stem.sphere_mass();
    std::string own;
    for (std::size_t i = 0; i < masses.size(); ++i)
        if (std::abs(masses[i] / plain - 1.0) > 1e-9) // less than the digits that are written
            own += fmt::format("set atom {} density {:.9g}\n", i + 1,
                               masses[i] / plain * stem.density);
    if (!own.empty())
        text += fmt::format("# spheres of another mass: atom 1 is clamped, atom {} is the tip; "
                            "repeat with the numbers of every further stem\n",
                            stem.sphere_count) +
                own;
    return text;
}

/// The calibrated gravity, in the axes of the calibration.
std::string gravity_line(const BulkStem& bulk) {
    for (const StoredEffect& effect : bulk.effects) {
        if (effect.name != "gravity")
            continue;
        const double axial = effect.values.at("axial_m_s2");
        const double transverse = effect.values.at("transverse_m_s2");
        const double magnitude = std::hypot(axial, transverse);
        if (magnitude > 0.0)
            return fmt::format("# x points from the clamp to the tip, y to the side of the pull; "
                               "in an input before the command that fixes the clamp\n"
                               "fix gravity all gravity {:.9g} vector {:.9g} {:.9g} 0\n",
                               magnitude, axial / magnitude, transverse / magnitude);
    }
    return {};
}

std::string liggghts_bond(const physics::StemParameters<double>& stem, int type, double damping) {
    return fmt::format("bond_coeff {} {:.9g} {:.9g} {:.9g} {:.9g} 1 {:.9g} 1 1.0e32 1.0e32\n", type,
                       stem.bond_outer_diameter / stem.sphere_diameter,
                       stem.bond_inner_diameter / stem.sphere_diameter, stem.bond_youngs_modulus,
                       stem.shear_modulus(), damping);
}

/// Bonds whose two spheres have a different reduced mass from two whole ones. `set` needs the
/// coefficients of all types.
std::string bonds_of_other_masses(const BulkStem& bulk, const std::vector<double>& masses,
                                  int& next_type) {
    constexpr double negligible = 1e-3; // of β
    const double plain = bulk.stem.sphere_mass();
    std::string coefficients;
    std::string types;
    for (std::size_t i = 0; i + 1 < masses.size(); ++i) {
        const double factor =
            std::sqrt(plain * (masses[i] + masses[i + 1]) / (2.0 * masses[i] * masses[i + 1]));
        if (std::abs(factor - 1.0) < negligible)
            continue;
        coefficients += liggghts_bond(bulk.stem, next_type, factor * bulk.stem.bond_damping);
        types += fmt::format("group bond{0} id {0} {1}\nset group bond{0} bond {2}\n", i + 1, i + 2,
                             next_type++);
    }
    if (!types.empty())
        coefficients += "# these act on bonds that exist: include them after the run that creates "
                        "the bonds\n";
    return coefficients + types;
}

} // namespace

void leave_out(std::span<BulkStem> stems, std::span<const std::string> names) {
    for (const std::string& name : names) {
        std::vector<std::string> present;
        bool is_found = false;
        for (BulkStem& bulk : stems) {
            for (const StoredEffect& effect : bulk.effects)
                present.push_back(effect.name);
            std::size_t removed = std::erase_if(
                bulk.effects, [&](const auto& effect) { return effect.name == name; });
            if (!bulk.added_masses.empty())
                present.emplace_back("added_mass");
            if (name == "added_mass") {
                removed += bulk.added_masses.size();
                bulk.added_masses.clear();
            }
            if (removed > 0)
                bulk.left_out.push_back(name);
            is_found = is_found || removed > 0;
        }
        if (is_found)
            continue;
        throw core::InputError(
            fmt::format("--without {}: not part of this calibration, which has {}{}", name,
                        present.empty() ? "no effects and no added mass"
                                        : fmt::format("{}", fmt::join(present, ", ")),
                        core::did_you_mean(name, present)));
    }
}

std::string liggghts_lines(const BulkStem& bulk, TypeNumbers& next) {
    require_exportable(bulk, "schramm2019", "the authors' code");
    const physics::StemParameters<double>& stem = bulk.stem;
    const double stiffness = stem.bond_youngs_modulus * std::numbers::pi *
                             stem.bond_outer_diameter * stem.bond_outer_diameter /
                             (4.0 * stem.bond_length);
    const double step =
        0.95 / ((1.1 + 2.9 * stem.bond_damping) * std::sqrt(stiffness / stem.sphere_mass()));
    const std::vector<double> masses = sphere_masses(bulk);
    std::string text = heading(bulk, "LIGGGHTS with flexible fibres");
    text += "# after create_atoms; needs bond_style gran and n_bondtypes of at least the largest "
            "bond type\n";
    text += sphere_lines(bulk, masses, next.atom++);
    text += "# bond type, outer and inner diameter over the sphere's, Y, G, damping type, beta, "
            "breakage type, critical normal and shear stress\n";
    text += liggghts_bond(stem, next.bond++, stem.bond_damping);
    text += bonds_of_other_masses(bulk, masses, next.bond);
    text += gravity_line(bulk);
    text += fmt::format("# largest step by that code's own rule: {:.4g} s\n", step);
    return text;
}

std::string lammps_lines(const BulkStem& bulk, LammpsVersion version, TypeNumbers& next) {
    require_exportable(bulk, "consistent", "LAMMPS's bpm/rotational");
    const bool is_new = version == LammpsVersion::From4July2026;
    const physics::StemParameters<double>& stem = bulk.stem;
    const auto bond = physics::make_bond_coefficients(stem, physics::consistent_law());
    run::CaseSpec spec;
    spec.stem = stem;
    spec.law = physics::consistent_law();
    std::string text = heading(bulk, "LAMMPS, package BPM");
    text += fmt::format(
        "# for LAMMPS {}\n"
        "# not carried over: bonds follow the spheres' orientations instead of rates (the same for "
        "small relative rotations of\n# neighbours); contacts and breakage are yours to set. "
        "Damping is that of two whole spheres in every bond.\n"
        "units si\natom_style bpm/sphere\nnewton on off\ncomm_modify vel yes\n"
        "special_bonds lj 0 1 1 coul 1 1 1\n"
        "# here: read_data or create_box and create_atoms, pair_style with its cutoff, bonds\n"
        "bond_style bpm/rotational break no smooth no{}\n",
        is_new ? "4 July 2026 and later" : "30 March 2026 and earlier",
        is_new ? " frame particle damping dem" : "");
    text += sphere_lines(bulk, sphere_masses(bulk), next.atom++);
    const double rolling = 2.0 * bond.bending_damping / bond.length;
    const double twisting = 2.0 * bond.torsion_damping;
    text += fmt::format(
        "# bond type, K_r N/m, K_s N/m, K_t N m, K_b N m, four critical loads that are never "
        "reached, gamma_r N s/m,\n# gamma_s N s/m, {}\n"
        "bond_coeff {} {:.9g} {:.9g} {:.9g} {:.9g} {:.9g} 1.0e32 1.0e32 1.0e32 {:.9g} {:.9g} "
        "{:.9g} {:.9g}\n",
        is_new ? "gamma_t (twist) N m s, gamma_b (roll) N s" : "gamma_roll N s, gamma_twist N m s",
        next.bond++, bond.normal_stiffness, bond.shear_stiffness, bond.torsion_stiffness,
        bond.bending_stiffness, bond.normal_stiffness * bond.length, bond.normal_damping,
        bond.shear_damping, is_new ? twisting : rolling, is_new ? rolling : twisting);
    text += gravity_line(bulk);
    text += fmt::format("# the clamped sphere neither moves nor turns: it is not integrated\n"
                        "group clamp id 1\ngroup moving subtract all clamp\n"
                        "fix motion moving nve/bpm/sphere\n"
                        "# largest stable step of the linearised chain: {:.4g} s\n",
                        run::largest_stable_timestep(spec));
    return text;
}

} // namespace culm::calibrate
