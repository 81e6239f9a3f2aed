// SPDX-License-Identifier: BSD-3-Clause
// Explicit integration in the order of the reference code, for one stem or one stem per SIMD lane.
#pragma once

#include "physics/chain.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

namespace culm::integrate {

/// Velocity Verlet with forces evaluated from the new positions and the half-step velocities:
/// half kick, drift, forces, half kick. Damping forces use the half-step velocity, so that the
/// scheme is of second order with damping. The bonds' elastic histories are advanced with the same
/// half-step rates and turned with the bond by projection at constant length, as the reference
/// code does.
///
/// The two half kicks between successive force evaluations are combined into one full kick. Between
/// calls the velocities are therefore half a step ahead, which state() corrects. The moments of
/// effects' Maxwell branches decay exactly; forces that depend on time use the end of the step.
template <int Dim, class T>
class VelocityVerlet {
    using Sphere = physics::SphereState<Dim, T>;
    using Bond = physics::BondState<Dim, T>;
    static constexpr int rotation = physics::rotation_dimension<Dim>;

  public:
    /// Starts from `state` (the chain's layout) with velocities at rest or given.
    VelocityVerlet(const physics::Chain<Dim, T>& chain, const std::vector<T>& state,
                   double timestep)
        : chain_(chain), timestep_(timestep), inverse_mass_(T(1.0) / chain.sphere_inertia().mass),
          inverse_moment_(T(1.0) / chain.sphere_inertia().moment) {
        const auto& layout = chain.layout();
        for (int i = 0; i < layout.sphere_count(); ++i)
            spheres_.push_back(layout.sphere(state.data(), i));
        for (int j = 0; j < layout.bond_count(); ++j)
            bonds_.push_back(layout.bond(state.data(), j));
        for (std::size_t j = 0; j < bonds_.size(); ++j)
            frames_.push_back(frame_of(j));
        before_ = spheres_;
        // The initial half kick uses the forces of the given state; nothing else advances.
        if (chain.is_plain()) {
            sweep<true>(T(0.0), T(0.5 * timestep));
        } else {
            take_effects(state);
            sweep<false>(T(0.0), T(0.5 * timestep));
        }
        // So that the mean of the velocities before and after is the given one.
        for (std::size_t i = 0; i < spheres_.size(); ++i) {
            before_[i].velocity += before_[i].velocity - spheres_[i].velocity;
            before_[i].spin += before_[i].spin - spheres_[i].spin;
        }
    }

    /// Takes `count` full steps; velocities are half a step ahead of positions afterwards.
    /// Flattened, because calls would pass vectors of SIMD lanes through memory: without this
    /// attribute the compiler calls the force law, and a step takes 2.4 times as long.
    [[gnu::flatten]] void advance(std::int64_t count) {
        if (!chain_.is_plain())
            return advance_with_effects(count);
        const T step = T(timestep_);
        for (std::int64_t k = 0; k < count; ++k) {
            if (k + 1 == count)
                before_ = spheres_;
            sweep<true>(step, step);
        }
    }

    /// Positions of sphere `i`, m.
    [[nodiscard]] const core::Vec<Dim, T>& position(int i) const {
        return spheres_[static_cast<std::size_t>(i)].position;
    }

    /// The state at the time of the positions, in the chain's layout: velocities are the mean of
    /// those before and after the last kick.
    [[nodiscard]] std::vector<T> state() const {
        const auto& layout = chain_.layout();
        std::vector<T> out(layout.size());
        const T half = T(0.5);
        for (int i = 0; i < layout.sphere_count(); ++i) {
            const auto index = static_cast<std::size_t>(i);
            Sphere sphere = spheres_[index];
            sphere.velocity = half * (sphere.velocity + before_[index].velocity);
            sphere.spin = half * (sphere.spin + before_[index].spin);
            layout.set_sphere(out.data(), i, sphere);
        }
        for (int j = 0; j < layout.bond_count(); ++j)
            layout.set_bond(out.data(), j, bonds_[static_cast<std::size_t>(j)]);
        layout.set_geometry(out.data());
        std::copy(branches_.begin(), branches_.end(),
                  out.begin() + static_cast<std::ptrdiff_t>(layout.branch_offset(0)));
        if (layout.base_turns())
            out[layout.base_rotation_offset()] = base_.rotation;
        if (layout.base_slips())
            out[layout.base_moment_offset()] = base_.moment;
        return out;
    }

  private:
    [[nodiscard]] physics::BondFrame<Dim, T> frame_of(std::size_t j) const {
        return physics::BondFrame<Dim, T>(spheres_[j + 1].position - spheres_[j].position);
    }

    [[gnu::flatten, gnu::noinline]] void advance_with_effects(std::int64_t count) {
        const T step = T(timestep_);
        for (std::int64_t k = 0; k < count; ++k) {
            if (k + 1 == count)
                before_ = spheres_;
            base_.rate = spheres_[0].spin[physics::bending_axis<Dim>];
            base_.rotation += step * base_.rate;
            if (const auto& slip = chain_.model().slip)
                base_.moment += step * physics::slip_rate(*chain_.model().hinge, *slip,
                                                          base_.moment, base_.rate)
                                           .value;
            ++steps_;
            sweep<false>(step, step);
        }
    }

    /// Copies branch moments and clamp rotation from the given state.
    void take_effects(const std::vector<T>& state) {
        const auto& layout = chain_.layout();
        branches_.assign(state.begin() + static_cast<std::ptrdiff_t>(layout.branch_offset(0)),
                         state.begin() +
                             static_cast<std::ptrdiff_t>(layout.base_rotation_offset()));
        if (layout.base_turns())
            base_ = chain_.base_state(state.data());
    }

    /// Drifts, turns the bonds, and kicks each sphere as soon as both of its bonds are known. In
    /// space all bonds are turned first: the operations on one bond wait for each other, and only
    /// those of a short loop overlap with the next bond's.
    template <bool IsPlain>
    void sweep(const T& step, const T& kick) {
        core::Vec<Dim, T> force = core::Vec<Dim, T>::zero();
        physics::Rotational<Dim, T> torque = physics::Rotational<Dim, T>::zero();
        if constexpr (!IsPlain) {
            if (chain_.base_turns())
                torque[physics::bending_axis<Dim>] =
                    chain_.clamp_moment(base_, time(), false).moment;
            below_ = {};
        }
        if (first_moving() == 0)
            spheres_[0].position += step * spheres_[0].velocity;
        for (std::size_t j = 0; Dim == 3 && j < bonds_.size(); ++j)
            frames_[j] = turned<IsPlain>(j, step);
        for (std::size_t j = 0; j < bonds_.size(); ++j) {
            const auto response = [&] {
                if constexpr (Dim == 3)
                    return load<IsPlain>(j, frames_[j], step);
                else
                    return load<IsPlain>(j, turned<IsPlain>(j, step), step);
            }();
            apply<IsPlain>(j, force + response.force, torque + response.torque_1, kick);
            force = -response.force;
            torque = response.torque_2;
        }
        apply<IsPlain>(bonds_.size(), force, torque, kick);
    }

    /// Lets the upper sphere of bond `j` drift, and turns the bond's history with it.
    template <bool IsPlain>
    [[nodiscard]] physics::BondFrame<Dim, T> turned(std::size_t j, const T& step) {
        spheres_[j + 1].position += step * spheres_[j + 1].velocity;
        const physics::BondFrame<Dim, T> frame = frame_of(j);
        bonds_[j].shear_force = frame.turned_shear(bonds_[j].shear_force);
        bonds_[j].moment = frame.turned_moment(bonds_[j].moment, frames_[j].direction());
        if constexpr (!IsPlain)
            advance_branches(j, frame, step);
        return frame;
    }

    /// Advances the history of bond `j` by its rates over `step` and returns the forces that
    /// follow: the new elastic parts and the damping of the same motion.
    template <bool IsPlain>
    [[nodiscard]] physics::BondResponse<Dim, T>
    load(std::size_t j, const physics::BondFrame<Dim, T>& frame, const T& step) {
        const auto motion = chain_.motion_between(spheres_[j], spheres_[j + 1]);
        const physics::BondCoefficients<T>& coefficients =
            IsPlain ? chain_.bond_coefficients() : chain_.bond_coefficients(static_cast<int>(j));
        const auto change =
            physics::history_change(coefficients, chain_.law(), frame, motion, step);
        bonds_[j].shear_force += change.shear_force;
        bonds_[j].moment += change.moment;
        Bond loaded = bonds_[j];
        if constexpr (!IsPlain)
            loaded.moment = physics::loaded_moment(chain_.model().bending,
                                                   chain_.model().bending_loss, coefficients, frame,
                                                   motion, loaded.moment, extras_of(j, motion));
        return physics::bond_response(coefficients, chain_.law(), frame, motion, loaded);
    }

    /// q ← q e^(−h/τ) + g k_b τ (1 − e^(−h/τ)) ω_bend, turned with the bond.
    void advance_branches(std::size_t j, const physics::BondFrame<Dim, T>& frame, const T& step) {
        using std::exp;
        const auto bending = frame.scaled(T(0.0), T(1.0), spheres_[j + 1].spin - spheres_[j].spin);
        const auto& model = chain_.model();
        for (std::size_t k = 0; k < model.branches.size(); ++k) {
            const physics::MaxwellBranch<T>& branch = model.branches[k];
            const T kept = exp(-step / branch.relaxation_time);
            const T stiffness = branch.relative_stiffness *
                                chain_.bond_coefficients(static_cast<int>(j)).bending_stiffness;
            T* const place = branch_moment(j, k);
            physics::Rotational<Dim, T> moment;
            std::copy_n(place, rotation, moment.component.begin());
            moment = kept * frame.turned_moment(moment, frames_[j].direction()) +
                     (stiffness * branch.relaxation_time * (T(1.0) - kept)) * bending;
            std::copy_n(moment.component.begin(), rotation, place);
        }
    }

    [[nodiscard]] T* branch_moment(std::size_t j, std::size_t branch) {
        return branches_.data() + (j * chain_.model().branches.size() + branch) * rotation;
    }

    /// As Chain::bond_extras, from the members of this class.
    [[nodiscard]] const physics::BondExtras<Dim, T>&
    extras_of(std::size_t j, const physics::BondMotion<Dim, T>& motion) {
        const physics::BondMoments<Dim, T> sum{bonds_[j].moment, branch_moment(j, 0)};
        below_ = chain_.bond_extras(static_cast<int>(j), spheres_[j], spheres_[j + 1], motion, sum,
                                    time(), false);
        return below_;
    }

    /// Kicks sphere `i`.
    template <bool IsPlain>
    void apply(std::size_t i, const core::Vec<Dim, T>& force,
               const physics::Rotational<Dim, T>& torque, const T& kick) {
        if (i < first_moving()) {
            if constexpr (!IsPlain) {
                constexpr int axis = physics::bending_axis<Dim>;
                if (chain_.base_turns())
                    spheres_[i].spin[axis] +=
                        kick * (torque[axis] / chain_.sphere_inertia(0).moment);
            }
            return;
        }
        Sphere& sphere = spheres_[i];
        if constexpr (IsPlain) {
            sphere.velocity += (kick * inverse_mass_) * force + kick * chain_.gravity();
            sphere.spin += (kick * inverse_moment_) * torque;
        } else {
            const int number = static_cast<int>(i);
            const physics::SphereInertia<T>& inertia = chain_.sphere_inertia(number);
            const auto load = chain_.node_load(number, sphere, below_, time(), false);
            sphere.velocity +=
                kick * chain_.acceleration(number, sphere.velocity, force + load.force);
            sphere.spin += kick * ((T(1.0) / inertia.moment) * torque);
        }
    }

    [[nodiscard]] std::size_t first_moving() const {
        return static_cast<std::size_t>(chain_.first_moving_sphere());
    }
    [[nodiscard]] T time() const { return T(static_cast<double>(steps_) * timestep_); }

    const physics::Chain<Dim, T>& chain_;
    double timestep_;
    T inverse_mass_;   ///< 1/kg
    T inverse_moment_; ///< 1/(kg m²)
    std::vector<Sphere> spheres_;
    std::vector<Bond> bonds_;
    std::vector<physics::BondFrame<Dim, T>>
        frames_;                        ///< of the bonds; in the plane those of the start
    std::vector<Sphere> before_;        ///< at the begin of the last step
    std::vector<T> branches_;           ///< Maxwell moments, as in the chain's layout
    physics::BondExtras<Dim, T> below_; ///< of the bond evaluated last
    physics::BaseState<T> base_;
    std::int64_t steps_ = 0;
};

} // namespace culm::integrate
