// SPDX-License-Identifier: BSD-3-Clause
// The chain of bonded spheres and its one right-hand side.
#pragma once

#include "physics/chain_layout.hpp"

#include <vector>

namespace culm::physics {

/// What holds the first sphere.
enum class Support {
    Clamped, ///< sphere 0 neither moves nor turns
    Free,    ///< nothing does: for conservation laws
};

/// A chain of equal spheres. Dim is 2 (the cantilever moves in a plane) or 3; T is double, SIMD
/// lanes (one stem per lane) or a dual number.
template <int Dim, class T>
class Chain {
  public:
    Chain(const StemParameters<T>& stem, const BondLawOptions& law,
          Support support = Support::Clamped)
        : layout_(stem.sphere_count), law_(law), support_(support),
          bond_(make_bond_coefficients(stem, law)),
          inertia_(make_sphere_inertia(stem)), inverse_inertia_{T(1.0) / inertia_.mass,
                                                                T(1.0) / inertia_.moment},
          acceleration_(Vec<Dim, T>::zero()) {
        acceleration_[0] = stem.axial_acceleration_of_gravity;
    }

    [[nodiscard]] const ChainLayout<Dim>& layout() const { return layout_; }
    [[nodiscard]] const BondLawOptions& law() const { return law_; }
    [[nodiscard]] const BondCoefficients<T>& bond_coefficients() const { return bond_; }
    [[nodiscard]] const SphereInertia<T>& sphere_inertia() const { return inertia_; }
    /// Acceleration of gravity in world axes, m/s².
    [[nodiscard]] const Vec<Dim, T>& gravity() const { return acceleration_; }
    /// The first sphere that moves: 1 when clamped, 0 when free.
    [[nodiscard]] int first_moving_sphere() const { return support_ == Support::Clamped ? 1 : 0; }

    /// Separation, relative velocity and spins of the two spheres of bond `j`.
    [[nodiscard]] static BondMotion<Dim, T> motion_between(const SphereState<Dim, T>& sphere_1,
                                                           const SphereState<Dim, T>& sphere_2) {
        return {sphere_2.position - sphere_1.position, sphere_2.velocity - sphere_1.velocity,
                sphere_1.spin, sphere_2.spin};
    }

    /// The straight, stress-free chain along axis 0 at rest, sphere 0 at the origin.
    [[nodiscard]] std::vector<T> straight_state() const {
        std::vector<T> state(layout_.size(), T(0.0));
        for (int i = 0; i < layout_.sphere_count(); ++i)
            state[layout_.sphere_offset(i)] = T(double(i)) * bond_.length;
        layout_.set_geometry(state.data());
        return state;
    }

    /// d(state)/dt. `state` and `rate` hold layout().size() numbers and must not overlap. The
    /// bonds' geometry must be set.
    [[gnu::flatten]] void evaluate_rate(const T* state, T* rate) const {
        SphereState<Dim, T> sphere_1 = layout_.sphere(state, 0);
        Vec<Dim, T> force = Vec<Dim, T>::zero();
        Rotational<Dim, T> torque = Rotational<Dim, T>::zero();
        for (int j = 0; j < layout_.bond_count(); ++j) {
            const SphereState<Dim, T> sphere_2 = layout_.sphere(state, j + 1);
            const BondState<Dim, T> elastic = layout_.bond(state, j);
            const BondMotion<Dim, T> motion = motion_between(sphere_1, sphere_2);
            const BondGeometry<Dim, T> geometry = layout_.geometry(state, j);
            const BondFrame<Dim, T> frame(geometry.length, geometry.direction);
            BondResponse<Dim, T> response = bond_response(bond_, law_, frame, motion, elastic);

            set_sphere_rate(rate, j, sphere_1, force + response.force, torque + response.torque_1);
            force = -response.force;
            torque = response.torque_2;

            response.rate.shear_force +=
                frame.shear_turning_rate(elastic.shear_force, motion.velocity);
            response.rate.moment += frame.moment_turning_rate(elastic.moment, motion.velocity);
            layout_.set_bond(rate, j, response.rate);
            layout_.set_geometry(rate, j, geometry_rate(frame, motion.velocity));
            sphere_1 = sphere_2;
        }
        set_sphere_rate(rate, layout_.bond_count(), sphere_1, force, torque);
    }

    /// l̇ = n·u and ṅ = (u − n l̇)/l, with u the relative velocity of the bond's spheres.
    [[nodiscard]] static BondGeometry<Dim, T> geometry_rate(const BondFrame<Dim, T>& frame,
                                                            const Vec<Dim, T>& velocity) {
        const T stretching = dot(velocity, frame.direction());
        return {stretching,
                (T(1.0) / frame.length()) * (velocity - stretching * frame.direction())};
    }

  private:
    void set_sphere_rate(T* rate, int i, const SphereState<Dim, T>& sphere,
                         const Vec<Dim, T>& force, const Rotational<Dim, T>& torque) const {
        SphereState<Dim, T> derivative;
        if (i < first_moving_sphere()) {
            derivative.position = Vec<Dim, T>::zero();
            derivative.velocity = Vec<Dim, T>::zero();
            derivative.spin = Rotational<Dim, T>::zero();
        } else {
            derivative.position = sphere.velocity;
            derivative.velocity = inverse_inertia_.mass * force + acceleration_;
            derivative.spin = inverse_inertia_.moment * torque;
        }
        layout_.set_sphere(rate, i, derivative);
    }

    ChainLayout<Dim> layout_;
    BondLawOptions law_;
    Support support_;
    BondCoefficients<T> bond_;
    SphereInertia<T> inertia_;
    SphereInertia<T> inverse_inertia_; ///< 1/kg and 1/(kg m²)
    Vec<Dim, T> acceleration_;
};

} // namespace culm::physics
