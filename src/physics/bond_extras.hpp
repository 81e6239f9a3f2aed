// SPDX-License-Identifier: BSD-3-Clause
// Moments of a bond in addition to the linear elastic one: Maxwell branches, nonlinear bending, a
// user's law.
#pragma once

#include "physics/bond_law.hpp"
#include "physics/chain_model.hpp"

#include <optional>

namespace culm::physics {

/// Component of a rotational quantity about the axis of bending in the plane of the pull.
template <int Dim>
inline constexpr int bending_axis = rotation_dimension<Dim> - 1;

/// Contributions of effects to a bond at one instant. A user's law is linearised about `curvature`
/// and `curvature_rate`, since an expression cannot use dual numbers; it is exact at that instant.
template <int Dim, class T>
struct BondExtras {
    Rotational<Dim, T> branches = Rotational<Dim, T>::zero(); ///< sum of their moments, N m
    T user = T(0.0);                                          ///< N m
    T user_by_curvature = T(0.0);                             ///< N m²
    T user_by_curvature_rate = T(0.0);                        ///< N m² s
    T curvature = T(0.0);                                     ///< 1/m
    T curvature_rate = T(0.0);                                ///< 1/(m s)
};

/// The moments of a bond that are states.
template <int Dim, class T>
struct BondMoments {
    Rotational<Dim, T> linear; ///< the linear elastic one, N m
    const T* branches;         ///< of the Maxwell branches, one after the other
};

/// Curvature that belongs to the linear elastic moment of a bond, 1/m, and its rate, 1/(m s).
template <int Dim, class S>
[[nodiscard]] S bond_curvature(const BondCoefficients<S>& bond,
                               const Rotational<Dim, S>& linear_moment) {
    return linear_moment[bending_axis<Dim>] / (bond.bending_stiffness * bond.length);
}
template <int Dim, class S>
[[nodiscard]] S bond_curvature_rate(const BondCoefficients<S>& bond,
                                    const BondMotion<Dim, S>& motion) {
    return (motion.spin_2 - motion.spin_1)[bending_axis<Dim>] / bond.length;
}

/// The moment that replaces the linear elastic one in the bond law. S is T or a dual
/// number over T.
template <int Dim, class S, class T>
[[nodiscard]] Rotational<Dim, S>
loaded_moment(const std::optional<BendingLaw<S>>& law, const std::optional<BendingLoss<S>>& loss,
              const BondCoefficients<S>& bond, const BondFrame<Dim, S>& frame,
              const BondMotion<Dim, S>& motion, const Rotational<Dim, S>& linear_moment,
              const BondExtras<Dim, T>& extras) {
    Rotational<Dim, S> moment =
        law ? elastic_moment(*law, bond.bending_stiffness * bond.length, frame, linear_moment)
            : linear_moment;
    for (int k = 0; k < rotation_dimension<Dim>; ++k)
        moment[k] = moment[k] + S(extras.branches[k]);
    const S curvature = bond_curvature<Dim>(bond, linear_moment);
    const S curvature_rate = bond_curvature_rate<Dim>(bond, motion);
    if (loss)
        moment[bending_axis<Dim>] =
            moment[bending_axis<Dim>] +
            bond.bending_stiffness * bond.length * loss_time(*loss, curvature) * curvature_rate;
    const S bent = curvature - S(extras.curvature);
    const S bending = curvature_rate - S(extras.curvature_rate);
    moment[bending_axis<Dim>] = moment[bending_axis<Dim>] + S(extras.user) +
                                S(extras.user_by_curvature) * bent +
                                S(extras.user_by_curvature_rate) * bending;
    return moment;
}

} // namespace culm::physics
