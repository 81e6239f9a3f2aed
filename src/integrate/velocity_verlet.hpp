// SPDX-License-Identifier: BSD-3-Clause
// Explicit integration in the order of the reference code, for one stem or one stem per SIMD lane.
#pragma once

#include "physics/chain.hpp"

#include <cstdint>
#include <vector>

namespace culm::integrate {

/// Velocity Verlet with forces evaluated from the new positions and the half-step velocities:
/// half kick, drift, forces, half kick. Damping forces see the half-step velocity, which keeps the
/// scheme of second order with damping. The bonds' elastic histories are advanced with the same
/// half-step rates and turned with the bond by projection at constant length, as the reference
/// code does.
///
/// The two half kicks between successive force evaluations are one full kick: the state holds
/// half-step velocities between calls, and state() takes the surplus back.
template <int Dim, class T>
class VelocityVerlet {
    using Sphere = physics::SphereState<Dim, T>;
    using Bond = physics::BondState<Dim, T>;

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
        directions_.resize(bonds_.size());
        for (std::size_t j = 0; j < bonds_.size(); ++j)
            directions_[j] = frame_of(j).direction();
        accelerations_.resize(spheres_.size());
        // The initial half kick sees the forces of the given state; no history advances.
        sweep(T(0.0), T(0.5 * timestep));
    }

    /// Takes `count` full steps; velocities are half a step ahead of positions afterwards.
    /// Flattened, because calls would pass vectors of SIMD lanes through memory: left to its own
    /// judgement the compiler calls the force law, and a step takes 2.4 times as long.
    [[gnu::flatten]] void advance(std::int64_t count) {
        const T step = T(timestep_);
        for (std::int64_t k = 0; k < count; ++k) {
            drift(step);
            sweep(step, step);
        }
    }

    /// Positions of sphere `i`, m.
    [[nodiscard]] const core::Vec<Dim, T>& position(int i) const {
        return spheres_[static_cast<std::size_t>(i)].position;
    }

    /// The state at the positions' time, in the chain's layout: half-step velocities are taken back
    /// by half a kick with the accelerations at hand.
    [[nodiscard]] std::vector<T> state() const {
        const auto& layout = chain_.layout();
        std::vector<T> out(layout.size());
        const T half = T(0.5 * timestep_);
        for (int i = 0; i < layout.sphere_count(); ++i) {
            const auto index = static_cast<std::size_t>(i);
            Sphere sphere = spheres_[index];
            sphere.velocity -= half * accelerations_[index].linear;
            sphere.spin -= half * accelerations_[index].angular;
            layout.set_sphere(out.data(), i, sphere);
        }
        for (int j = 0; j < layout.bond_count(); ++j)
            layout.set_bond(out.data(), j, bonds_[static_cast<std::size_t>(j)]);
        layout.set_geometry(out.data());
        return out;
    }

  private:
    struct Acceleration {
        core::Vec<Dim, T> linear = core::Vec<Dim, T>::zero();
        physics::Rotational<Dim, T> angular = physics::Rotational<Dim, T>::zero();
    };

    [[nodiscard]] physics::BondFrame<Dim, T> frame_of(std::size_t j) const {
        return physics::BondFrame<Dim, T>(spheres_[j + 1].position - spheres_[j].position);
    }

    void drift(const T& step) {
        for (std::size_t i = first_moving(); i < spheres_.size(); ++i)
            spheres_[i].position += step * spheres_[i].velocity;
    }

    /// Forces along the chain; each sphere is kicked as soon as both of its bonds are known.
    void sweep(const T& history_step, const T& kick) {
        core::Vec<Dim, T> force = core::Vec<Dim, T>::zero();
        physics::Rotational<Dim, T> torque = physics::Rotational<Dim, T>::zero();
        for (std::size_t j = 0; j < bonds_.size(); ++j) {
            const auto motion = chain_.motion_between(spheres_[j], spheres_[j + 1]);
            const physics::BondFrame<Dim, T> frame(motion.separation);
            const auto response = advance_bond(j, frame, motion, history_step);
            apply(j, force + response.force, torque + response.torque_1, kick);
            force = -response.force;
            torque = response.torque_2;
        }
        apply(bonds_.size(), force, torque, kick);
    }

    /// Advances the bond's history by its rates over `history_step` and returns the forces that
    /// follow: the new elastic parts and the damping of the same motion.
    [[nodiscard]] physics::BondResponse<Dim, T>
    advance_bond(std::size_t j, const physics::BondFrame<Dim, T>& frame,
                 const physics::BondMotion<Dim, T>& motion, const T& history_step) {
        Bond& bond = bonds_[j];
        bond.shear_force = frame.turned_shear(bond.shear_force);
        bond.moment = frame.turned_moment(bond.moment, directions_[j]);
        directions_[j] = frame.direction();
        const auto rate =
            physics::history_rate(chain_.bond_coefficients(), chain_.law(), frame, motion);
        bond.shear_force += history_step * rate.shear_force;
        bond.moment += history_step * rate.moment;
        return physics::bond_response(chain_.bond_coefficients(), chain_.law(), frame, motion,
                                      bond);
    }

    void apply(std::size_t i, const core::Vec<Dim, T>& force,
               const physics::Rotational<Dim, T>& torque, const T& kick) {
        if (i < first_moving())
            return;
        Acceleration& acceleration = accelerations_[i];
        acceleration.linear = inverse_mass_ * force + chain_.gravity();
        acceleration.angular = inverse_moment_ * torque;
        spheres_[i].velocity += kick * acceleration.linear;
        spheres_[i].spin += kick * acceleration.angular;
    }

    [[nodiscard]] std::size_t first_moving() const {
        return static_cast<std::size_t>(chain_.first_moving_sphere());
    }

    const physics::Chain<Dim, T>& chain_;
    double timestep_;
    T inverse_mass_;   ///< 1/kg
    T inverse_moment_; ///< 1/(kg m²)
    std::vector<Sphere> spheres_;
    std::vector<Bond> bonds_;
    std::vector<core::Vec<Dim, T>> directions_; ///< of the bonds at the last force evaluation
    std::vector<Acceleration> accelerations_;   ///< of the last force evaluation
};

} // namespace culm::integrate
