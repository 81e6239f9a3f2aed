// SPDX-License-Identifier: BSD-3-Clause
#include "run/case_model.hpp"

#include "core/lanes.hpp"
#include "physics/effects/library.hpp"

#include <algorithm>
#include <optional>
#include <vector>

namespace culm::run {

measure::MeasuredStem described_stem(const CaseSpec& spec) {
    const physics::StemParameters<double>& stem = spec.stem;
    measure::MeasuredStem described;
    described.length = stem.free_length();
    measure::CircularSection section{stem.bond_outer_diameter, {}};
    if (stem.bond_inner_diameter > 0.0)
        section.wall = 0.5 * (stem.bond_outer_diameter - stem.bond_inner_diameter);
    described.section = section;
    described.is_density_of_spheres = false;
    described.density = 1.0;
    described.density = stem.sphere_mass() / stem.bond_length / measure::mass_per_length(described);
    return described;
}
namespace {

using physics::ChainModel;
using Model = ChainModel<double>;

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
            list.push_back(number([&](const Model& model) { return get(model)[k]; }));
        return list;
    }

    /// The structs of a list, each with the numbers `members`.
    template <class Packed, class Part, class... Member>
    [[nodiscard]] std::vector<Packed> parts(std::vector<Part> Model::*list,
                                            Member Part::*... members) const {
        std::vector<Packed> packed;
        for (std::size_t k = 0; k < (first().*list).size(); ++k)
            packed.push_back(
                {number([&](const Model& model) { return (model.*list)[k].*members; })...});
        return packed;
    }

    /// The same of a struct that the models may lack.
    template <class Packed, class Part, class... Member>
    [[nodiscard]] std::optional<Packed> part(std::optional<Part> Model::*whole,
                                             Member Part::*... members) const {
        if (!(first().*whole))
            return std::nullopt;
        return Packed{number([&](const Model& model) { return (*(model.*whole)).*members; })...};
    }

    [[nodiscard]] const Model& first() const { return models_.front().chain; }

  private:
    std::span<const CaseModel> models_;
};

template <class T>
void pack_stem(const Packer<T>& packer, ChainModel<T>& packed) {
    using Bond = physics::BondCoefficients<double>;
    packed.bonds = packer.template parts<physics::BondCoefficients<T>>(
        &Model::bonds, &Bond::length, &Bond::span, &Bond::share_1, &Bond::share_2,
        &Bond::normal_stiffness, &Bond::shear_stiffness, &Bond::torsion_stiffness,
        &Bond::bending_stiffness, &Bond::normal_damping, &Bond::shear_damping,
        &Bond::torsion_damping, &Bond::bending_damping);
    using Sphere = physics::SphereInertia<double>;
    packed.spheres = packer.template parts<physics::SphereInertia<T>>(
        &Model::spheres, &Sphere::mass, &Sphere::moment);
    packed.straight_moments =
        packer.numbers([](const auto& model) -> const auto& { return model.straight_moments; });
    using Branch = physics::MaxwellBranch<double>;
    packed.branches = packer.template parts<physics::MaxwellBranch<T>>(
        &Model::branches, &Branch::relative_stiffness, &Branch::relaxation_time,
        &Branch::held_share);
    using Bending = physics::BendingLaw<double>;
    packed.bending = packer.template part<physics::BendingLaw<T>>(&Model::bending, &Bending::cubic,
                                                                  &Bending::split, &Bending::angle);
    using Loss = physics::BendingLoss<double>;
    packed.bending_loss = packer.template part<physics::BendingLoss<T>>(
        &Model::bending_loss, &Loss::time, &Loss::power, &Loss::curvature);
}

template <class T>
void pack_surroundings(const Packer<T>& packer, ChainModel<T>& packed) {
    for (int d = 0; d < 3; ++d)
        packed.gravity[d] = packer.number([d](const auto& model) { return model.gravity[d]; });
    for (std::size_t k = 0; k < packer.first().air.size(); ++k)
        packed.air.push_back(
            {packer.first().air[k].law,
             packer.number([k](const auto& model) { return model.air[k].coefficient; }),
             packer.numbers([k](const auto& model) -> const auto& { return model.air[k].shape; })});
    using Hinge = physics::BaseHinge<double>;
    packed.hinge = packer.template part<physics::BaseHinge<T>>(
        &Model::hinge, &Hinge::stiffness, &Hinge::friction_moment, &Hinge::friction_rate,
        &Hinge::damping);
    using Slip = physics::JointSlip<double>;
    packed.slip =
        packer.template part<physics::JointSlip<T>>(&Model::slip, &Slip::share, &Slip::power);
    using Air = physics::AirMass<double>;
    packed.air_mass = packer.template part<physics::AirMass<T>>(
        &Model::air_mass, &Air::constant, &Air::growing, &Air::smallest_speed);
    using Base = physics::BaseMotion<double>;
    packed.base_motion = packer.template part<physics::BaseMotion<T>>(
        &Model::base_motion, &Base::amplitude, &Base::angular_frequency, &Base::phase);
    using Gradual = physics::GradualRelease<double>;
    packed.release = packer.template part<physics::GradualRelease<T>>(
        &Model::release, &Gradual::duration, &Gradual::holding_force);
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
    target.attached = spec.added_masses;
    physics::apply_effects(spec.effects, target);
    return model;
}

int dimensions_of(const CaseSpec& spec) {
    int dimensions = spec.dimensions;
    for (const physics::ActiveEffect& active : spec.effects)
        dimensions = std::max(dimensions, active.effect->dimensions);
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
    pack_stem(packer, packed);
    pack_surroundings(packer, packed);
    return packed;
}

template physics::ChainModel<double> packed_model(std::span<const CaseModel>);
template physics::ChainModel<core::Lanes> packed_model(std::span<const CaseModel>);

} // namespace culm::run
