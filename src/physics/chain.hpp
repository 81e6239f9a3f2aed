// SPDX-License-Identifier: BSD-3-Clause
// The chain of bonded spheres and its one right-hand side.
#pragma once

#include "physics/bond_extras.hpp"
#include "physics/chain_layout.hpp"

#include <span>
#include <utility>
#include <vector>

namespace culm::physics {

/// Support of the first sphere.
enum class Support {
    Clamped, ///< sphere 0 does not move; it turns only if the model has a hinge
    Free,    ///< no support: for conservation laws
};

/// A chain of spheres. Dim is 2 (the cantilever moves in a plane) or 3; T is double, SIMD lanes
/// (one stem per lane) or a dual number.
template <int Dim, class T>
class Chain {
  public:
    /// The published chain of equal spheres and bonds.
    Chain(const StemParameters<T>& stem, const BondLawOptions& law,
          Support support = Support::Clamped)
        : Chain(stem.sphere_count, plain_chain(stem, law), law, support) {}

    /// A chain with effects.
    Chain(int sphere_count, ChainModel<T> model, const BondLawOptions& law,
          Support support = Support::Clamped)
        : layout_(sphere_count, static_cast<int>(model.branches.size()), model.base_turns(),
                  model.slip.has_value()),
          law_(law), support_(support), is_plain_(model.is_plain()), bond_(model.bonds.front()),
          inertia_(model.spheres.front()), inverse_inertia_{T(1.0) / inertia_.mass,
                                                            T(1.0) / inertia_.moment},
          gravity_(Vec<Dim, T>::zero()), model_(std::move(model)) {
        for (int d = 0; d < Dim; ++d)
            gravity_[d] = model_.gravity[d];
    }

    [[nodiscard]] const ChainLayout<Dim>& layout() const { return layout_; }
    [[nodiscard]] const BondLawOptions& law() const { return law_; }
    [[nodiscard]] const ChainModel<T>& model() const { return model_; }
    /// True for equal spheres and bonds without effects: loops may reuse one bond's coefficients.
    [[nodiscard]] bool is_plain() const { return is_plain_; }
    [[nodiscard]] const BondCoefficients<T>& bond_coefficients(int j = 0) const {
        return model_.bonds.size() == 1 ? bond_ : model_.bonds[static_cast<std::size_t>(j)];
    }
    [[nodiscard]] const SphereInertia<T>& sphere_inertia(int i = 0) const {
        return model_.spheres.size() == 1 ? inertia_ : model_.spheres[static_cast<std::size_t>(i)];
    }
    /// Acceleration of gravity in world axes, m/s².
    [[nodiscard]] const Vec<Dim, T>& gravity() const { return gravity_; }
    /// The first sphere that moves: 1 when clamped, 0 when free.
    [[nodiscard]] int first_moving_sphere() const { return support_ == Support::Clamped ? 1 : 0; }
    /// Length of the stem that sphere `i` represents, m: l, and half of it at the two ends.
    [[nodiscard]] T length_at(int i) const {
        return i == 0 || i == layout_.bond_count() ? T(0.5) * bond_.length : bond_.length;
    }
    /// Does clamped sphere 0 turn in the plane of bending?
    [[nodiscard]] bool base_turns() const { return layout_.base_turns(); }
    /// State of the clamp that turns.
    [[nodiscard]] BaseState<T> base_state(const T* state) const {
        return {state[layout_.base_rotation_offset()],
                layout_.sphere(state, 0).spin[bending_axis<Dim>],
                layout_.base_slips() ? state[layout_.base_moment_offset()] : T(0.0)};
    }
    /// The air that moves with sphere `i`.
    [[nodiscard]] MovedAir<T> air_at(int i, const Vec<Dim, T>& velocity) const {
        return model_.air_mass
                   ? moved_air(*model_.air_mass, length_at(i), squared_sideways(velocity))
                   : MovedAir<T>{};
    }
    /// Its kinetic energy, J.
    [[nodiscard]] T air_energy(int i, const Vec<Dim, T>& velocity) const {
        return model_.air_mass
                   ? moved_air_energy(*model_.air_mass, length_at(i), squared_sideways(velocity))
                   : T(0.0);
    }
    /// Acceleration of sphere `i` under a force besides gravity, m/s². Air adds to its inertia
    /// sideways and not to its weight.
    [[nodiscard]] Vec<Dim, T> acceleration(int i, const Vec<Dim, T>& velocity,
                                           const Vec<Dim, T>& force) const {
        const T& mass = sphere_inertia(i).mass;
        Vec<Dim, T> sum = (T(1.0) / mass) * force + gravity_;
        if (model_.air_mass) {
            const T share = mass / (mass + air_at(i, velocity).mass);
            for (int k = 1; k < Dim; ++k)
                sum[k] = share * sum[k];
        }
        return sum;
    }

    /// Separation, relative velocity and spins of the two spheres of a bond.
    [[nodiscard]] static BondMotion<Dim, T> motion_between(const SphereState<Dim, T>& sphere_1,
                                                           const SphereState<Dim, T>& sphere_2) {
        return {sphere_2.position - sphere_1.position, sphere_2.velocity - sphere_1.velocity,
                sphere_1.spin, sphere_2.spin};
    }

    /// The straight chain along axis 0 at rest, sphere 0 at the origin. It is stress-free unless
    /// the stem is naturally curved.
    [[nodiscard]] std::vector<T> straight_state() const {
        std::vector<T> state(layout_.size(), T(0.0));
        for (int i = 0; i < layout_.sphere_count(); ++i)
            state[layout_.sphere_offset(i)] = T(double(i)) * bond_.length;
        layout_.set_geometry(state.data());
        return state;
    }

    /// The straight chain when it is held straight: with the moments of a naturally curved stem.
    [[nodiscard]] std::vector<T> held_straight_state() const {
        std::vector<T> state = straight_state();
        for (std::size_t j = 0; j < model_.straight_moments.size(); ++j) {
            BondState<Dim, T> bond = layout_.bond(state.data(), static_cast<int>(j));
            bond.moment[bending_axis<Dim>] = model_.straight_moments[j];
            layout_.set_bond(state.data(), static_cast<int>(j), bond);
        }
        return state;
    }

    /// d(state)/dt at `time` (s, from the release). `state` and `rate` hold layout().size() numbers
    /// and must not overlap. The bonds' geometry must be set.
    void evaluate_rate(const T* state, T* rate, const T& time = T(0.0)) const {
        if (is_plain_)
            evaluate_plain(state, rate);
        else
            evaluate_with_effects(state, rate, time);
    }

    /// l̇ = n·u and ṅ = (u − n l̇)/l, with u the relative velocity of the bond's spheres.
    [[nodiscard]] static BondGeometry<Dim, T> geometry_rate(const BondFrame<Dim, T>& frame,
                                                            const Vec<Dim, T>& velocity) {
        const T stretching = dot(velocity, frame.direction());
        return {stretching,
                (T(1.0) / frame.length()) * (velocity - stretching * frame.direction())};
    }

    /// External forces on sphere `i` except gravity. `bond_below` gives the curvature and its rate,
    /// which a user's law may use. Slopes of user laws are computed only on request.
    [[nodiscard]] NodeLoad<Dim, T> node_load(int i, const SphereState<Dim, T>& sphere,
                                             const BondExtras<Dim, T>& bond_below, const T& time,
                                             bool with_slopes) const {
        NodeLoad<Dim, T> load;
        if (!model_.air.empty())
            add_air_drag(std::span<const AirDrag<T>>(model_.air), length_at(i), sphere.velocity,
                         load);
        if (model_.base_motion)
            load.force[1] =
                load.force[1] + (sphere_inertia(i).mass + air_at(i, sphere.velocity).mass) *
                                    base_acceleration(*model_.base_motion, time);
        if (model_.release && i == layout_.bond_count())
            load.force[1] = load.force[1] + finger_force(*model_.release, time);
        if (!model_.user_laws.empty()) {
            const NodeLoad<Dim, T> user = user_load(i, sphere, bond_below, time, with_slopes);
            load.force += user.force;
            load.by_velocity[1] += user.by_velocity[1];
            load.by_deflection = user.by_deflection;
        }
        return load;
    }

    /// The part of node_load that users' laws exert.
    [[nodiscard]] NodeLoad<Dim, T> user_load(int i, const SphereState<Dim, T>& sphere,
                                             const BondExtras<Dim, T>& bond_below, const T& time,
                                             bool with_slopes) const {
        using Inputs = UserLawInputsOf<T>;
        const Inputs inputs{T(double(i)) * bond_.length, sphere.position[1],
                            sphere.velocity[1],          bond_below.curvature,
                            bond_below.curvature_rate,   time};
        const T length = length_at(i);
        NodeLoad<Dim, T> load;
        T& by_velocity = load.by_velocity[1][1];
        for (const UserLaw<T>& law : model_.user_laws) {
            if (law.kind != UserLawKind::ForcePerLength)
                continue;
            load.force[1] += length * user_law_value(law, inputs);
            if (!with_slopes)
                continue;
            by_velocity += length * user_law_slope(law, inputs, &Inputs::velocity, 1.0);
            load.by_deflection += length * user_law_slope(law, inputs, &Inputs::deflection, 0.01);
        }
        return load;
    }

    /// Moments of bond `j` besides the linear elastic one; slopes of user laws only on request.
    [[nodiscard]] BondExtras<Dim, T> bond_extras(const T* state, int j, const T& time,
                                                 bool with_slopes) const {
        const SphereState<Dim, T> sphere_1 = layout_.sphere(state, j);
        const SphereState<Dim, T> sphere_2 = layout_.sphere(state, j + 1);
        return bond_extras(j, sphere_1, sphere_2, motion_between(sphere_1, sphere_2),
                           {layout_.bond(state, j).moment, state + layout_.branch_offset(j)}, time,
                           with_slopes);
    }
    [[nodiscard]] BondExtras<Dim, T> bond_extras(int j, const SphereState<Dim, T>& sphere_1,
                                                 const SphereState<Dim, T>& sphere_2,
                                                 const BondMotion<Dim, T>& motion,
                                                 const BondMoments<Dim, T>& moments, const T& time,
                                                 bool with_slopes) const {
        BondExtras<Dim, T> extras;
        for (int k = 0; k < layout_.branch_count(); ++k)
            for (int d = 0; d < ChainLayout<Dim>::rotation; ++d)
                extras.branches[d] =
                    extras.branches[d] + moments.branches[k * ChainLayout<Dim>::rotation + d];
        if (model_.user_laws.empty())
            return extras;
        extras.curvature = bond_curvature<Dim>(bond_coefficients(j), moments.linear);
        extras.curvature_rate = bond_curvature_rate<Dim>(bond_coefficients(j), motion);
        const T half = T(0.5);
        using Inputs = UserLawInputsOf<T>;
        const Inputs inputs{T(j + 0.5) * bond_.length,
                            half * (sphere_1.position[1] + sphere_2.position[1]),
                            half * (sphere_1.velocity[1] + sphere_2.velocity[1]),
                            extras.curvature,
                            extras.curvature_rate,
                            time};
        for (const UserLaw<T>& law : model_.user_laws) {
            if (law.kind != UserLawKind::BendingMoment)
                continue;
            extras.user += user_law_value(law, inputs);
            if (!with_slopes)
                continue;
            extras.user_by_curvature += user_law_slope(law, inputs, &Inputs::curvature, 1.0);
            extras.user_by_curvature_rate +=
                user_law_slope(law, inputs, &Inputs::curvature_rate, 100.0);
        }
        return extras;
    }

    /// Moment of the clamp on sphere 0. That of a joint which slips does not depend on the
    /// rotation.
    [[nodiscard]] HingeMoment<T> clamp_moment(const BaseState<T>& base, const T& time,
                                              bool with_slopes) const {
        HingeMoment<T> sum;
        if (model_.slip) {
            sum = hinge_moment(*model_.hinge, T(0.0), base.rate);
            sum.moment = sum.moment - base.moment;
            sum.by_rotation = T(0.0);
        } else if (model_.hinge) {
            sum = hinge_moment(*model_.hinge, base.rotation, base.rate);
        }
        for (const UserLaw<T>& law : model_.user_laws) {
            if (law.kind != UserLawKind::BaseMoment)
                continue;
            using Inputs = UserLawInputsOf<T>;
            const Inputs inputs{T(0.0), base.rotation, base.rate, T(0.0), T(0.0), time};
            sum.moment += user_law_value(law, inputs);
            if (!with_slopes)
                continue;
            sum.by_rotation += user_law_slope(law, inputs, &Inputs::deflection, 0.1);
            sum.by_rate += user_law_slope(law, inputs, &Inputs::velocity, 10.0);
        }
        return sum;
    }

  private:
    [[nodiscard]] static T squared_sideways(const Vec<Dim, T>& velocity) {
        T square = T(0.0);
        for (int k = 1; k < Dim; ++k)
            square = square + velocity[k] * velocity[k];
        return square;
    }

    [[gnu::flatten]] void evaluate_plain(const T* state, T* rate) const {
        evaluate<false>(state, rate, T(0.0));
    }
    [[gnu::flatten, gnu::noinline]] void evaluate_with_effects(const T* state, T* rate,
                                                               const T& time) const {
        evaluate<true>(state, rate, time);
    }

    /// Proceeds from the clamp to the tip. The force of a bond on its first sphere completes the
    /// sum for that sphere; its force on the second sphere starts the next sum. A plain chain has
    /// only bonds and reuses the coefficients of one bond.
    template <bool has_effects>
    void evaluate(const T* state, T* rate, const T& time) const {
        SphereState<Dim, T> sphere_1 = layout_.sphere(state, 0);
        Vec<Dim, T> force = Vec<Dim, T>::zero();
        Rotational<Dim, T> torque = Rotational<Dim, T>::zero();
        if (has_effects && base_turns()) {
            const BaseState<T> base = base_state(state);
            torque[bending_axis<Dim>] = clamp_moment(base, time, false).moment;
            rate[layout_.base_rotation_offset()] = base.rate;
            if (model_.slip)
                rate[layout_.base_moment_offset()] =
                    slip_rate(*model_.hinge, *model_.slip, base.moment, base.rate).value;
        }
        BondExtras<Dim, T> below;
        for (int j = 0; j < layout_.bond_count(); ++j) {
            const SphereState<Dim, T> sphere_2 = layout_.sphere(state, j + 1);
            const BondMotion<Dim, T> motion = motion_between(sphere_1, sphere_2);
            const BondFrame<Dim, T> frame = frame_of(state, j);
            const BondCoefficients<T>& bond = has_effects ? bond_coefficients(j) : bond_;
            const BondState<Dim, T> elastic = layout_.bond(state, j);
            BondState<Dim, T> loaded = elastic;
            BondExtras<Dim, T> extras;
            if constexpr (has_effects) {
                extras = bond_extras(state, j, time, false);
                loaded.moment = loaded_moment(model_.bending, model_.bending_loss, bond, frame,
                                              motion, elastic.moment, extras);
            }
            const BondResponse<Dim, T> response = bond_response(bond, law_, frame, motion, loaded);
            finish_sphere<has_effects>(rate, j, sphere_1, below, time, force + response.force,
                                       torque + response.torque_1);
            force = -response.force;
            torque = response.torque_2;
            set_bond_rate(rate, j, frame, motion, elastic, response.rate);
            if constexpr (has_effects)
                set_branch_rates(state, rate, j, frame, motion);
            sphere_1 = sphere_2;
            below = extras;
        }
        finish_sphere<has_effects>(rate, layout_.bond_count(), sphere_1, below, time, force,
                                   torque);
    }

    /// The rate of a sphere from the force and torque of the bonds and from external loads.
    template <bool has_effects>
    void finish_sphere(T* rate, int i, const SphereState<Dim, T>& sphere,
                       const BondExtras<Dim, T>& below, const T& time, const Vec<Dim, T>& force,
                       const Rotational<Dim, T>& torque) const {
        if constexpr (has_effects)
            set_sphere_rate(rate, i, sphere,
                            acceleration(i, sphere.velocity,
                                         force + node_load(i, sphere, below, time, false).force),
                            (T(1.0) / sphere_inertia(i).moment) * torque);
        else
            set_sphere_rate(rate, i, sphere, inverse_inertia_.mass * force + gravity_,
                            inverse_inertia_.moment * torque);
    }

    [[nodiscard]] BondFrame<Dim, T> frame_of(const T* state, int j) const {
        const BondGeometry<Dim, T> geometry = layout_.geometry(state, j);
        return BondFrame<Dim, T>(geometry.length, geometry.direction);
    }

    void set_bond_rate(T* rate, int j, const BondFrame<Dim, T>& frame,
                       const BondMotion<Dim, T>& motion, const BondState<Dim, T>& elastic,
                       BondState<Dim, T> bond_rate) const {
        bond_rate.shear_force += frame.shear_turning_rate(elastic.shear_force, motion.velocity);
        bond_rate.moment += frame.moment_turning_rate(elastic.moment, motion.velocity);
        layout_.set_bond(rate, j, bond_rate);
        layout_.set_geometry(rate, j, geometry_rate(frame, motion.velocity));
    }

    /// q̇ = g k_b ω_bend − q/τ, turned with the bond.
    void set_branch_rates(const T* state, T* rate, int j, const BondFrame<Dim, T>& frame,
                          const BondMotion<Dim, T>& motion) const {
        const Rotational<Dim, T> bending =
            frame.scaled(T(0.0), T(1.0), motion.spin_2 - motion.spin_1);
        for (int k = 0; k < layout_.branch_count(); ++k) {
            const MaxwellBranch<T>& branch = model_.branches[static_cast<std::size_t>(k)];
            const Rotational<Dim, T> moment = layout_.branch_moment(state, j, k);
            const T stiffness = branch.relative_stiffness * bond_coefficients(j).bending_stiffness;
            Rotational<Dim, T> branch_rate = stiffness * bending;
            branch_rate -= (T(1.0) / branch.relaxation_time) * moment;
            branch_rate += frame.moment_turning_rate(moment, motion.velocity);
            layout_.set_branch_moment(rate, j, k, branch_rate);
        }
    }

    void set_sphere_rate(T* rate, int i, const SphereState<Dim, T>& sphere,
                         const Vec<Dim, T>& acceleration, const Rotational<Dim, T>& turning) const {
        SphereState<Dim, T> derivative;
        if (i < first_moving_sphere()) {
            derivative.position = Vec<Dim, T>::zero();
            derivative.velocity = Vec<Dim, T>::zero();
            derivative.spin = Rotational<Dim, T>::zero();
            if (base_turns())
                derivative.spin[bending_axis<Dim>] = turning[bending_axis<Dim>];
        } else {
            derivative.position = sphere.velocity;
            derivative.velocity = acceleration;
            derivative.spin = turning;
        }
        layout_.set_sphere(rate, i, derivative);
    }

    ChainLayout<Dim> layout_;
    BondLawOptions law_;
    Support support_;
    bool is_plain_;
    BondCoefficients<T> bond_;         ///< the first one
    SphereInertia<T> inertia_;         ///< the first one
    SphereInertia<T> inverse_inertia_; ///< 1/kg and 1/(kg m²)
    Vec<Dim, T> gravity_;
    ChainModel<T> model_;
};

} // namespace culm::physics
