// SPDX-License-Identifier: BSD-3-Clause
// Bending moments that are not proportional to the curvature, or not alike in all directions.
#pragma once

#include "physics/bond_frame.hpp"

#include <cmath>

namespace culm::physics {

/// M = E I κ (1 + γ κ²) in every principal plane, whose stiffnesses differ by `split`.
template <class T>
struct BendingLaw {
    T cubic = T(0.0); ///< γ, m²
    T split = T(0.0); ///< (k_1 − k_2)/k_b, of the stiffnesses of the two principal planes
    T angle = T(0.0); ///< from the plane of the pull to the principal plane 1, rad
};

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
    const Rotational<3, S> twisting = frame.twist(linear_moment);
    const Rotational<3, S> bending = linear_moment - twisting;
    const Vec<3, S> in_plane{{S(0.0), cos(law.angle), sin(law.angle)}};
    const Vec<3, S> normal = cross(frame.direction(), in_plane);
    const Vec<3, S> axis_1 = (S(1.0) / sqrt(dot(normal, normal))) * normal;
    const Vec<3, S> axis_2 = cross(frame.direction(), axis_1);
    const S share = S(0.5) * law.split;
    const Vec<3, S> split = share * (dot(bending, axis_1) * axis_1 - dot(bending, axis_2) * axis_2);
    const S factor =
        S(1.0) + law.cubic * dot(bending, bending) / (moment_per_curvature * moment_per_curvature);
    return twisting + factor * bending + split;
}

} // namespace culm::physics
