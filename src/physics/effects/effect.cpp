// SPDX-License-Identifier: BSD-3-Clause
#include "physics/effects/effect.hpp"

#include "core/error.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

namespace culm::physics {

namespace {

/// Damping may be absent (β = 0); then it stays absent.
double ratio(double changed, double plain) {
    return plain == 0.0 ? 1.0 : changed / plain;
}

void multiply(BondCoefficients<double>& bond, const BondCoefficients<double>& changed,
              const BondCoefficients<double>& plain) {
    for (const auto member :
         {&BondCoefficients<double>::normal_stiffness, &BondCoefficients<double>::shear_stiffness,
          &BondCoefficients<double>::torsion_stiffness,
          &BondCoefficients<double>::bending_stiffness, &BondCoefficients<double>::normal_damping,
          &BondCoefficients<double>::shear_damping, &BondCoefficients<double>::torsion_damping,
          &BondCoefficients<double>::bending_damping})
        bond.*member *= ratio(changed.*member, plain.*member);
}

std::size_t index(int i) {
    return static_cast<std::size_t>(i);
}

} // namespace

std::string_view to_string(FittedAs fitted_as) {
    constexpr std::array names{"as it is", "as its logarithm", "as its inverse"};
    return names[static_cast<std::size_t>(fitted_as)];
}

std::string_view to_string(Family family) {
    constexpr std::array names{"material damping",   "air",     "clamp",  "stem geometry",
                               "support and camera", "release", "weight", "own law"};
    return names[static_cast<std::size_t>(family)];
}

bool is_one_law(Family family) {
    return family == Family::MaterialDamping || family == Family::Air;
}

std::vector<EffectParameter> Effect::parameters_for(const StemParameters<double>& stem) const {
    std::vector<EffectParameter> suited = parameters;
    if (suit_ != nullptr)
        suit_(stem, suited);
    return suited;
}

std::vector<PlanarPart> Effect::planar_parts_of(std::span<const double> values) const {
    return planar_parts == nullptr ? std::vector<PlanarPart>() : planar_parts(values);
}

void expand_links(ChainModel<double>& model, int sphere_count) {
    const std::size_t spheres = index(sphere_count);
    if (model.bonds.size() == 1)
        model.bonds.assign(spheres - 1, BondCoefficients<double>(model.bonds.front()));
    if (model.spheres.size() == 1)
        model.spheres.assign(spheres, SphereInertia<double>(model.spheres.front()));
}

void change_along_stem(EffectTarget& target, const LocalStem& local) {
    const StemParameters<double>& stem = target.stem;
    expand_links(target.model, stem.sphere_count);
    const BondCoefficients<double> plain_bond = make_bond_coefficients(stem, target.law);
    const SphereInertia<double> plain_sphere = make_sphere_inertia(stem);
    for (int i = 0; i < stem.sphere_count; ++i) {
        const SphereInertia<double> changed =
            make_sphere_inertia(local(stem, double(i) * stem.bond_length));
        SphereInertia<double>& sphere = target.model.spheres[index(i)];
        sphere.mass *= changed.mass / plain_sphere.mass;
        sphere.moment *= changed.moment / plain_sphere.moment;
    }
    for (int j = 0; j + 1 < stem.sphere_count; ++j)
        multiply(
            target.model.bonds[index(j)],
            make_bond_coefficients(local(stem, (double(j) + 0.5) * stem.bond_length), target.law),
            plain_bond);
}

void join_attached_masses(EffectTarget& target) {
    const StemParameters<double>& stem = target.stem;
    for (const AttachedMass& attached : target.attached) {
        if (!(attached.position >= 0.0))
            throw core::InputError(
                fmt::format("a mass at {} m: must be at or above the clamp", attached.position));
        expand_links(target.model, stem.sphere_count);
        // Lever rule: the two neighbours together have the attached mass and its centre.
        const double place = std::min(attached.position / stem.bond_length,
                                      static_cast<double>(stem.sphere_count - 1));
        const int below = std::min(static_cast<int>(std::floor(place)), stem.sphere_count - 2);
        const double share = place - static_cast<double>(below);
        target.model.spheres[index(below)].mass += (1.0 - share) * attached.mass;
        target.model.spheres[index(below + 1)].mass += share * attached.mass;
    }
    target.attached.clear();
}

} // namespace culm::physics
