// SPDX-License-Identifier: BSD-3-Clause
#include "run/case_model.hpp"

#include "core/lanes.hpp"
#include "physics/effects/library.hpp"
#include "physics/effects/per_link.hpp"

#include <algorithm>

namespace culm::run {
namespace {

using physics::ChainModel;

/// Gathers single numbers and lists of them from the models of all lanes.
template <class T>
class Packer {
  public:
    explicit Packer(std::span<const CaseModel> models) : models_(models) {}

    /// The number that `get` finds in a lane's model.
    template <class Get>
    [[nodiscard]] T number(const Get& get) const {
        return core::by_lane<T>(
            [&](std::size_t lane) { return get(models_[lane < models_.size() ? lane : 0].chain); });
    }

    /// The list of numbers that `get` finds, as long in every lane.
    template <class Get>
    [[nodiscard]] std::vector<T> numbers(const Get& get) const {
        std::vector<T> list;
        for (std::size_t k = 0; k < get(first()).size(); ++k)
            list.push_back(number([&](const ChainModel<double>& model) { return get(model)[k]; }));
        return list;
    }

    /// A struct of the numbers `members`, found by `get`.
    template <class Packed, class Part, class Get, class... Member>
    [[nodiscard]] Packed part(const Get& get, Member Part::*... members) const {
        return Packed{
            number([&](const ChainModel<double>& model) { return get(model).*members; })...};
    }

    [[nodiscard]] const ChainModel<double>& first() const { return models_.front().chain; }

  private:
    std::span<const CaseModel> models_;
};

template <class T>
void pack_links(const Packer<T>& packer, ChainModel<T>& packed) {
    using Bond = physics::BondCoefficients<double>;
    for (std::size_t j = 0; j < packer.first().bonds.size(); ++j)
        packed.bonds.push_back(packer.template part<physics::BondCoefficients<T>>(
            [j](const auto& model) -> const Bond& { return model.bonds[j]; }, &Bond::length,
            &Bond::radius_1, &Bond::radius_2, &Bond::normal_stiffness, &Bond::shear_stiffness,
            &Bond::torsion_stiffness, &Bond::bending_stiffness, &Bond::normal_damping,
            &Bond::shear_damping, &Bond::torsion_damping, &Bond::bending_damping));
    using Sphere = physics::SphereInertia<double>;
    for (std::size_t i = 0; i < packer.first().spheres.size(); ++i)
        packed.spheres.push_back(packer.template part<physics::SphereInertia<T>>(
            [i](const auto& model) -> const Sphere& { return model.spheres[i]; }, &Sphere::mass,
            &Sphere::moment));
    for (std::size_t k = 0; k < packer.first().air.size(); ++k)
        packed.air.push_back(
            {packer.first().air[k].law,
             packer.number([k](const auto& model) { return model.air[k].coefficient; }),
             packer.numbers([k](const auto& model) -> const auto& { return model.air[k].shape; })});
    packed.straight_moments =
        packer.numbers([](const auto& model) -> const auto& { return model.straight_moments; });
    for (int d = 0; d < 3; ++d)
        packed.gravity[d] = packer.number([d](const auto& model) { return model.gravity[d]; });
}

template <class T>
void pack_clamp_and_bending(const Packer<T>& packer, ChainModel<T>& packed) {
    using Hinge = physics::BaseHinge<double>;
    if (packer.first().hinge)
        packed.hinge = packer.template part<physics::BaseHinge<T>>(
            [](const auto& model) -> const Hinge& { return *model.hinge; }, &Hinge::stiffness,
            &Hinge::friction_moment, &Hinge::friction_rate);
    using Branch = physics::MaxwellBranch<double>;
    for (std::size_t k = 0; k < packer.first().branches.size(); ++k)
        packed.branches.push_back(packer.template part<physics::MaxwellBranch<T>>(
            [k](const auto& model) -> const Branch& { return model.branches[k]; },
            &Branch::relative_stiffness, &Branch::relaxation_time, &Branch::held_share));
    using Bending = physics::BendingLaw<double>;
    if (packer.first().bending)
        packed.bending = packer.template part<physics::BendingLaw<T>>(
            [](const auto& model) -> const Bending& { return *model.bending; }, &Bending::cubic,
            &Bending::split, &Bending::angle);
}

template <class T>
void pack_time_dependence(const Packer<T>& packer, ChainModel<T>& packed) {
    using Base = physics::BaseMotion<double>;
    if (packer.first().base_motion)
        packed.base_motion = packer.template part<physics::BaseMotion<T>>(
            [](const auto& model) -> const Base& { return *model.base_motion; }, &Base::amplitude,
            &Base::angular_frequency, &Base::phase);
    using Gradual = physics::GradualRelease<double>;
    if (packer.first().release)
        packed.release = packer.template part<physics::GradualRelease<T>>(
            [](const auto& model) -> const Gradual& { return *model.release; }, &Gradual::duration,
            &Gradual::holding_force);
    for (std::size_t k = 0; k < packer.first().user_laws.size(); ++k) {
        const physics::UserLaw<double>& law = packer.first().user_laws[k];
        packed.user_laws.push_back(
            {law.kind, law.expression, packer.numbers([k](const auto& model) -> const auto& {
                 return model.user_laws[k].parameters;
             })});
    }
}

} // namespace

CaseModel case_model(const CaseSpec& spec) {
    CaseModel model{physics::plain_chain(spec.stem, spec.law), {}};
    model.camera.readout_time = spec.readout_time;
    physics::EffectTarget target{spec.stem, spec.law, model.chain, model.camera};
    if (spec.stem.tip_mass_share != 1.0) {
        physics::expand_links(model.chain, spec.stem.sphere_count);
        physics::SphereInertia<double>& tip = model.chain.spheres.back();
        tip.mass *= spec.stem.tip_mass_share;
        tip.moment *= spec.stem.tip_mass_share;
    }
    // Known masses are attached after all effects, so that an effect that scales the stem's mass
    // (taper) does not change them.
    for (const PointMass& added : spec.added_masses)
        target.attached.push_back({added.height, added.mass});
    physics::apply_effects(spec.effects, target);
    return model;
}

int dimensions_of(const CaseSpec& spec) {
    int dimensions = spec.dimensions;
    for (const physics::ActiveEffect& active : spec.effects)
        dimensions = std::max(dimensions, active.effect->dimensions());
    return dimensions;
}

bool same_kind_of_model(const CaseSpec& a, const CaseSpec& b) {
    // packed_model takes the terms from the first lane and the numbers from every lane.
    return (a.stem.tip_mass_share == 1.0) == (b.stem.tip_mass_share == 1.0) &&
           a.added_masses.empty() == b.added_masses.empty() &&
           std::equal(a.effects.begin(), a.effects.end(), b.effects.begin(), b.effects.end(),
                      [](const auto& x, const auto& y) { return x.effect == y.effect; });
}

template <class T>
physics::ChainModel<T> packed_model(std::span<const CaseModel> models) {
    const Packer<T> packer(models);
    physics::ChainModel<T> packed;
    pack_links(packer, packed);
    pack_clamp_and_bending(packer, packed);
    pack_time_dependence(packer, packed);
    return packed;
}

template physics::ChainModel<double> packed_model(std::span<const CaseModel>);
template physics::ChainModel<core::Lanes> packed_model(std::span<const CaseModel>);

} // namespace culm::run
