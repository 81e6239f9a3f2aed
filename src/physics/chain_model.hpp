// SPDX-License-Identifier: BSD-3-Clause
// Parts of a chain beyond equal spheres and bonds: everything that a physical effect may add to
// the published model.
#pragma once

#include "core/vec.hpp"
#include "physics/air_drag.hpp"
#include "physics/bond_coefficients.hpp"
#include "physics/bond_frame.hpp"
#include "physics/clamp_law.hpp"
#include "physics/user_law.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

namespace culm::physics {

/// M = E I κ (1 + γ κ²) in every principal plane, whose stiffnesses differ by `split`.
template <class T>
struct BendingLaw {
    T cubic = T(0.0); ///< γ, m²
    T split = T(0.0); ///< (k_1 − k_2)/k_b, of the stiffnesses of the two principal planes
    T angle = T(0.0); ///< from the plane of the pull to the principal plane 1, rad
};

/// A loss that grows with the bend in the plane of the pull: M = E I δ (|κ|/κ_r)ᵖ κ̇.
template <class T>
struct BendingLoss {
    T time;      ///< δ, s
    T power;     ///< p
    T curvature; ///< κ_r, 1/m
};

/// δ (|κ|/κ_r)ᵖ, s. For p < 1 its slope is infinite at κ = 0; below 1e-5 κ_r it is smooth.
template <class S>
[[nodiscard]] S loss_time(const BendingLoss<S>& loss, const S& curvature) {
    using std::exp;
    using std::log;
    const S ratio = curvature / loss.curvature;
    return loss.time * exp(S(0.5) * loss.power * log(ratio * ratio + S(1e-10)));
}

/// The elastic moment of a bond whose linear, isotropic law would give `linear_moment` = k_b times
/// the bending angle. `moment_per_curvature` is k_b l = E I. The cubic term comes from a section
/// that flattens (Brazier 1927) or stiffens; it is the lowest one that symmetry allows.
template <class S>
[[nodiscard]] Rotational<2, S>
elastic_moment(const BendingLaw<S>& law, const S& moment_per_curvature,
               const BondFrame<2, S>& /*frame*/, const Rotational<2, S>& linear_moment) {
    const S curvature = linear_moment[0] / moment_per_curvature;
    return {{linear_moment[0] * (S(1.0) + law.cubic * curvature * curvature)}};
}

/// In space the twist passes unchanged. The principal axes turn with the bond's direction; the
/// stem's twist, which would turn them further, is neglected (it is of second order).
template <class S>
[[nodiscard]] Rotational<3, S>
elastic_moment(const BendingLaw<S>& law, const S& moment_per_curvature,
               const BondFrame<3, S>& frame, const Rotational<3, S>& linear_moment) {
    using std::cos;
    using std::sin;
    using std::sqrt;
    const Rotational<3, S> bending = frame.transverse(linear_moment);
    const Vec<3, S> in_plane{{S(0.0), cos(law.angle), sin(law.angle)}};
    const Vec<3, S> normal = cross(frame.direction(), in_plane);
    const Vec<3, S> axis_1 = (S(1.0) / sqrt(dot(normal, normal))) * normal;
    const Vec<3, S> axis_2 = cross(frame.direction(), axis_1);
    const S share = S(0.5) * law.split;
    const Vec<3, S> split = share * (dot(bending, axis_1) * axis_1 - dot(bending, axis_2) * axis_2);
    const S factor =
        S(1.0) + law.cubic * dot(bending, bending) / (moment_per_curvature * moment_per_curvature);
    return frame.scaled(S(1.0), factor, linear_moment) + split;
}

/// A spring and a dashpot in series, parallel to the bending spring of every bond:
/// q̇ = g k_b ω − q/τ, with the relative spin ω across the bond.
template <class T>
struct MaxwellBranch {
    T relative_stiffness; ///< g
    T relaxation_time;    ///< τ, s
    T held_share;         ///< share of g times the bond's moment that remains at the release
};

/// The support moves sideways: x_b(t) = a sin(2πft + φ). The chain is described in its frame.
template <class T>
struct BaseMotion {
    T amplitude;         ///< a, m
    T angular_frequency; ///< 2πf, rad/s
    T phase;             ///< φ, rad
};

/// Sideways displacement of the support from its mean position, m.
template <class T>
[[nodiscard]] T base_position(const BaseMotion<T>& motion, const T& time) {
    using std::sin;
    return motion.amplitude * sin(motion.angular_frequency * time + motion.phase);
}

/// Inertial acceleration in the frame of the support, −ẍ_b, m/s².
template <class T>
[[nodiscard]] T base_acceleration(const BaseMotion<T>& motion, const T& time) {
    return motion.angular_frequency * motion.angular_frequency * base_position(motion, time);
}

/// The finger lets go gradually: the tip's holding force falls to zero over `duration` along
/// 1 − 3u² + 2u³.
template <class T>
struct GradualRelease {
    T duration;      ///< s
    T holding_force; ///< on the tip, sideways, N; known once the stem has been deflected
};

/// Sideways force of the finger on the tip, N.
template <class T>
[[nodiscard]] T finger_force(const GradualRelease<T>& release, const T& time) {
    using std::max;
    using std::min;
    const T progress = max(T(0.0), min(T(1.0), time / release.duration));
    return release.holding_force * (T(1.0) - progress * progress * (T(3.0) - T(2.0) * progress));
}

/// A list with a single entry applies to all bonds or spheres of the chain.
template <class T>
struct ChainModel {
    std::vector<BondCoefficients<T>> bonds; ///< (1) or (bonds)
    std::vector<SphereInertia<T>> spheres;  ///< (1) or (spheres)
    core::Vec<3, T> gravity;                ///< acceleration in world axes, m/s²

    std::optional<BaseHinge<T>> hinge;
    std::optional<JointSlip<T>> slip; ///< of the hinge's spring
    std::vector<MaxwellBranch<T>> branches;
    std::vector<AirDrag<T>> air; ///< one for each law
    std::optional<AirMass<T>> air_mass;
    std::optional<BendingLaw<T>> bending;
    std::optional<BendingLoss<T>> bending_loss;
    /// Elastic moment of each bond when the chain is straight, about the axis of bending, N m;
    /// (0) or (bonds). A stem that is curved at rest resists being straightened.
    std::vector<T> straight_moments;
    std::optional<BaseMotion<T>> base_motion;
    std::optional<GradualRelease<T>> release;
    std::vector<UserLaw<T>> user_laws;

    /// True for a chain of equal spheres and bonds alone, under axial gravity or none.
    [[nodiscard]] bool is_plain() const {
        return bonds.size() == 1 && spheres.size() == 1 && !hinge && branches.empty() &&
               air.empty() && !air_mass && !bending && !bending_loss && straight_moments.empty() &&
               !base_motion && !release && user_laws.empty();
    }
    [[nodiscard]] bool depends_on_time() const {
        return base_motion || release || !user_laws.empty();
    }
    /// Does sphere 0 turn?
    [[nodiscard]] bool base_turns() const {
        return hinge || std::ranges::find(user_laws, UserLawKind::BaseMoment, &UserLaw<T>::kind) !=
                            user_laws.end();
    }
};

/// The chain of equal spheres and bonds that `stem` describes.
template <class T>
[[nodiscard]] ChainModel<T> plain_chain(const StemParameters<T>& stem, const BondLawOptions& law) {
    ChainModel<T> model;
    model.bonds = {make_bond_coefficients(stem, law)};
    model.spheres = {make_sphere_inertia(stem)};
    model.gravity = core::Vec<3, T>::zero();
    model.gravity[0] = stem.axial_acceleration_of_gravity;
    return model;
}

} // namespace culm::physics
