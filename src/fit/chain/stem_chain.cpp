// SPDX-License-Identifier: BSD-3-Clause
#include "fit/chain/stem_chain.hpp"

#include "core/error.hpp"
#include "physics/bond_coefficients.hpp"

#include <cmath>
#include <numbers>
#include <utility>

#include <fmt/core.h>

namespace culm::fit {

namespace {

constexpr int fewest_spheres = 5; // a cubic through four of them, and the clamp
constexpr int most_spheres = 1000;

/// Sets outer and inner diameter of the bonds, the width that faces the air, and of stems with a
/// section its shear correction and rotary inertia. Returns a sentence on the properties of the
/// section that the bonds cannot represent; empty if there are none.
std::string set_section(const measure::MeasuredStem& measured,
                        physics::StemParameters<double>& stem) {
    if (const auto* circle = std::get_if<measure::CircularSection>(&measured.section)) {
        stem.bond_outer_diameter = circle->diameter;
        stem.bond_inner_diameter = circle->wall ? circle->diameter - 2.0 * *circle->wall : 0.0;
        return {};
    }
    if (const auto* rectangle = std::get_if<measure::RectangularSection>(&measured.section)) {
        stem.width_across_motion = rectangle->width;
        stem.rectangle_depth = rectangle->height;
    }
    // A ring has A = π(d_o² − d_i²)/4 and I = A (d_o² + d_i²)/16.
    const double area = measure::section_area(measured.section);
    const double second_moment = measure::second_moment_of_area(measured.section);
    // Timoshenko's shear correction of a rectangle (Cowper 1966); general sections take it too.
    const double poissons_ratio = measured.poissons_ratio.value_or(stem.poissons_ratio);
    const double correction = 10.0 * (1.0 + poissons_ratio) / (12.0 + 11.0 * poissons_ratio);
    stem.shear_area_share = correction;
    stem.rotary_inertia_share = 1.0;
    const double sum = 16.0 * second_moment / area;
    const double difference = 4.0 * area / std::numbers::pi;
    if (sum >= difference) {
        stem.bond_outer_diameter = std::sqrt(0.5 * (sum + difference));
        stem.bond_inner_diameter = std::sqrt(0.5 * (sum - difference));
        return {};
    }
    stem.bond_outer_diameter = std::pow(64.0 * second_moment / std::numbers::pi, 0.25);
    stem.bond_inner_diameter = 0.0;
    stem.rotary_inertia_share = stem.section_area() / area;
    stem.shear_area_share = correction / stem.rotary_inertia_share;
    return fmt::format("{}: a section this flat has no ring of the same area and second moment; "
                       "the bonds have its second moment and {:.2g} of its area, on which only "
                       "stretching depends",
                       measured.id, stem.section_area() / area);
}

void divide(double length, double mass_per_length, int spheres,
            physics::StemParameters<double>& stem) {
    stem.sphere_count = spheres;
    stem.bond_length = length / (spheres - 1);
    stem.sphere_diameter = stem.bond_length;
    // A sphere of diameter l weighs ρπl³/6 and represents the length l of stem.
    stem.density = mass_per_length * 6.0 / (std::numbers::pi * stem.bond_length * stem.bond_length);
}

} // namespace

std::string set_geometry(const measure::MeasuredStem& measured, int spheres,
                         physics::StemParameters<double>& stem) {
    divide(measured.length, measure::mass_per_length(measured), spheres, stem);
    return set_section(measured, stem);
}

StemChain chain_of(const measure::Measurement& measurement, const ChainOptions& options) {
    const measure::MeasuredStem& measured = measurement.stem;
    const int spheres = options.spheres.value_or(measured.spheres.value_or(default_sphere_count));
    if (spheres < fewest_spheres || spheres > most_spheres)
        throw core::InputError(fmt::format("{}: a chain of {} spheres; {} … {} are allowed",
                                           measured.id, spheres, fewest_spheres, most_spheres));
    StemChain chain;
    physics::StemParameters<double>& stem = chain.spec.stem;
    if (std::string remark = set_geometry(measured, spheres, stem); !remark.empty())
        chain.remarks.push_back(std::move(remark));
    // The stem ends at the centre of the last sphere, which represents half a bond length.
    stem.tip_mass_share = 0.5;
    stem.poissons_ratio = measured.poissons_ratio.value_or(stem.poissons_ratio);
    chain.spec.law = options.law;
    chain.spec.integrator.relative_tolerance = options.relative_tolerance;
    chain.spec.store = run::StoreLevel::Heights;
    chain.spec.heights = measurement.heights;
    chain.spec.sensors = measurement.sensors;
    chain.spec.reading = measurement.reading;
    if (measurement.row_time && measurement.row_height)
        chain.spec.readout_time = *measurement.row_time * measured.length / *measurement.row_height;
    chain.spec.release = measurement.release == measure::ReleaseKind::HeldStraight
                             ? run::Release::HeldStraight
                             : run::Release::TipPull;
    for (const measure::AddedMass& mass : measured.added_masses)
        chain.spec.added_masses.push_back({mass.height, mass.mass});
    return chain;
}

run::CaseSpec with_spheres(run::CaseSpec spec, int spheres) {
    physics::StemParameters<double>& stem = spec.stem;
    const double wanted = damping_time(spec);
    divide(stem.free_length(), stem.sphere_mass() / stem.bond_length, spheres, stem);
    if (wanted > 0.0)
        stem.bond_damping *= wanted / damping_time(spec); // which is proportional to β
    return spec;
}

double damping_time(const run::CaseSpec& spec) {
    const auto bond = physics::make_bond_coefficients(spec.stem, spec.law);
    const double bending = bond.bending_damping / bond.bending_stiffness;
    // A slender beam of such bonds has the stiffness EI (1 + iωτ_b)(1 + iωτ_s) where the shear
    // dashpots exert no torque and EI (1 + iωτ_b) where they do (docs/physics.md): to first order
    // the times add.
    return spec.law.shear_damping_torque ? bending
                                         : bending + bond.shear_damping / bond.shear_stiffness;
}

} // namespace culm::fit
