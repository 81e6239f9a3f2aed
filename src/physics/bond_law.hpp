// SPDX-License-Identifier: BSD-3-Clause
// The force law of a bond: Eqs. 3-10 of Schramm et al. (2019) in rate form.
#pragma once

#include "physics/bond_coefficients.hpp"
#include "physics/bond_frame.hpp"

namespace culm::physics {

/// How the two spheres of a bond move. Sphere 1 is the one nearer to the clamp.
template <int Dim, class T>
struct BondMotion {
    Vec<Dim, T> separation;    ///< x2 − x1, m
    Vec<Dim, T> velocity;      ///< v2 − v1, m/s
    Rotational<Dim, T> spin_1; ///< rad/s
    Rotational<Dim, T> spin_2;
};

/// The elastic history of a bond; the normal force needs none.
template <int Dim, class T>
struct BondState {
    Rotational<Dim, T> shear_force; ///< elastic shear force on sphere 1, N
    Rotational<Dim, T> moment;      ///< elastic torsion and bending moment on sphere 1, N m
};

/// Forces and torques of a bond, and the rates of its elastic history.
template <int Dim, class T>
struct BondResponse {
    Vec<Dim, T> force;           ///< on sphere 1, N; sphere 2 receives the opposite
    Rotational<Dim, T> torque_1; ///< N m
    Rotational<Dim, T> torque_2;
    BondState<Dim, T> rate; ///< without the turning with the bond, N/s and N m/s
};

/// Lever arms of the shear force: the radii, or their shares of the current length.
template <class T>
struct LeverArms {
    T arm_1;
    T arm_2;
};

template <class T>
[[nodiscard]] LeverArms<T> lever_arms(const BondCoefficients<T>& bond, const BondLawOptions& law,
                                      const T& current_length) {
    const T span = law.lever_arms_follow_bond ? current_length : bond.span;
    return {span * bond.share_1, span * bond.share_2};
}

/// Relative velocity of the contact point across the bond: the transverse part of v2 − v1 less the
/// spins of both spheres over their lever arms.
template <int Dim, class T>
[[nodiscard]] Rotational<Dim, T> shear_velocity(const BondFrame<Dim, T>& frame,
                                                const BondMotion<Dim, T>& motion,
                                                const LeverArms<T>& arms) {
    return frame.transverse(motion.velocity) -
           frame.spin_velocity(arms.arm_1 * motion.spin_1 + arms.arm_2 * motion.spin_2);
}

/// Changes of the elastic shear force and moments during `step` (Eqs. 3-6), without the turning
/// with the bond.
template <int Dim, class T>
[[nodiscard]] BondState<Dim, T>
history_change(const BondCoefficients<T>& bond, const BondLawOptions& law,
               const BondFrame<Dim, T>& frame, const BondMotion<Dim, T>& motion, const T& step) {
    const Rotational<Dim, T> sliding =
        shear_velocity(frame, motion, lever_arms(bond, law, frame.length()));
    return {(step * bond.shear_stiffness) * sliding,
            frame.scaled(step * bond.torsion_stiffness, step * bond.bending_stiffness,
                         motion.spin_2 - motion.spin_1)};
}

/// The bond law. Elastic forces are those of `state`; damping forces follow the motion
/// (`2β √(inertia × stiffness) × rate`, Eqs. 7-10). With `law.shear_damping_torque` off, the shear
/// damping force moves the spheres but exerts no torque, as in the authors' public code.
template <int Dim, class T>
[[nodiscard]] BondResponse<Dim, T>
bond_response(const BondCoefficients<T>& bond, const BondLawOptions& law,
              const BondFrame<Dim, T>& frame, const BondMotion<Dim, T>& motion,
              const BondState<Dim, T>& state) {
    const LeverArms<T> arms = lever_arms(bond, law, frame.length());
    const Rotational<Dim, T> sliding = shear_velocity(frame, motion, arms);
    const T stretching = dot(motion.velocity, frame.direction());

    const T tension =
        bond.normal_stiffness * (frame.length() - bond.length) + bond.normal_damping * stretching;
    const Rotational<Dim, T> damped_shear = state.shear_force + bond.shear_damping * sliding;
    const Rotational<Dim, T> moment =
        state.moment +
        frame.scaled(bond.torsion_damping, bond.bending_damping, motion.spin_2 - motion.spin_1);
    Rotational<Dim, T> shear_moment = frame.moment_of(damped_shear);
    if (!law.shear_damping_torque)
        shear_moment = frame.moment_of(state.shear_force);

    BondResponse<Dim, T> response;
    response.force = tension * frame.direction() + frame.to_world(damped_shear);
    response.torque_1 = arms.arm_1 * shear_moment + moment;
    response.torque_2 = arms.arm_2 * shear_moment - moment;
    response.rate = history_change(bond, law, frame, motion, T(1.0));
    return response;
}

} // namespace culm::physics
