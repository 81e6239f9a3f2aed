// SPDX-License-Identifier: BSD-3-Clause
// Layout of the state of a chain in a flat array.
#pragma once

#include "physics/bond_law.hpp"

#include <algorithm>
#include <cstddef>

namespace culm::physics {

/// State of one sphere.
template <int Dim, class T>
struct SphereState {
    Vec<Dim, T> position;    ///< m; axis 0 points from the clamp along the stem, axis 1 to the pull
    Vec<Dim, T> velocity;    ///< m/s
    Rotational<Dim, T> spin; ///< rad/s
};

/// Length and direction of a bond, which are states in addition to the positions of the spheres.
template <int Dim, class T>
struct BondGeometry {
    T length;              ///< m
    Vec<Dim, T> direction; ///< from sphere 1 to sphere 2; its magnitude is 1 up to rounding
};

/// The flat state: first every sphere (position, velocity, spin), from the clamp to the tip, then
/// every bond's history (elastic shear force, elastic moment), then every bond's geometry. That is
/// 10 numbers a link in the plane and 19 in space. Effects append the moments of the Maxwell
/// branches, bond by bond, the rotation of the clamp in the plane of bending, and its moment if it
/// slips. Rotation angles of the other spheres are not states. The same layout holds the rates.
///
/// Length and direction follow from the positions. As states they allow an implicit method to take
/// 2.6 times longer steps: |x2 − x1| of a turning bond is quadratic in the displacements, and a
/// Jacobian frozen over a step misses this term times the axial stiffness. Forces use the geometry,
/// the camera uses the positions. set_geometry() makes them consistent at the start.
template <int Dim>
class ChainLayout {
  public:
    static constexpr int rotation = rotation_dimension<Dim>;
    static constexpr int sphere_size = 2 * Dim + rotation;
    static constexpr int bond_size = 2 * rotation;
    static constexpr int geometry_size = 1 + Dim;

    explicit ChainLayout(int sphere_count, int branch_count = 0, bool base_turns = false,
                         bool base_slips = false)
        : sphere_count_(sphere_count), branch_count_(branch_count), base_turns_(base_turns),
          base_slips_(base_slips) {}

    [[nodiscard]] int sphere_count() const { return sphere_count_; }
    [[nodiscard]] int bond_count() const { return sphere_count_ - 1; }
    [[nodiscard]] int branch_count() const { return branch_count_; }
    [[nodiscard]] bool base_turns() const { return base_turns_; }
    [[nodiscard]] bool base_slips() const { return base_slips_; }
    [[nodiscard]] std::size_t size() const {
        return base_moment_offset() + (base_slips_ ? 1U : 0U);
    }

    [[nodiscard]] std::size_t sphere_offset(int sphere) const {
        return static_cast<std::size_t>(sphere) * sphere_size;
    }
    /// Bond `bond` joins spheres `bond` and `bond + 1`.
    [[nodiscard]] std::size_t bond_offset(int bond) const {
        return static_cast<std::size_t>(sphere_count_) * sphere_size +
               static_cast<std::size_t>(bond) * bond_size;
    }

    [[nodiscard]] std::size_t geometry_offset(int bond) const {
        return bond_offset(bond_count()) + static_cast<std::size_t>(bond) * geometry_size;
    }

    /// Moments of bond `bond`'s Maxwell branches, `rotation` numbers each.
    [[nodiscard]] std::size_t branch_offset(int bond) const {
        return geometry_offset(bond_count()) +
               static_cast<std::size_t>(bond) * static_cast<std::size_t>(branch_count_) * rotation;
    }
    /// Offset of the rotation (rad) of a clamp that turns.
    [[nodiscard]] std::size_t base_rotation_offset() const { return branch_offset(bond_count()); }
    /// Offset of the moment (N m) of a clamp that slips.
    [[nodiscard]] std::size_t base_moment_offset() const {
        return base_rotation_offset() + (base_turns_ ? 1U : 0U);
    }

    template <class T>
    [[nodiscard]] SphereState<Dim, T> sphere(const T* state, int i) const {
        const T* from = state + sphere_offset(i);
        SphereState<Dim, T> sphere;
        std::copy_n(from, Dim, sphere.position.component.begin());
        std::copy_n(from + Dim, Dim, sphere.velocity.component.begin());
        std::copy_n(from + 2 * Dim, rotation, sphere.spin.component.begin());
        return sphere;
    }
    template <class T>
    void set_sphere(T* state, int i, const SphereState<Dim, T>& sphere) const {
        T* to = state + sphere_offset(i);
        std::copy_n(sphere.position.component.begin(), Dim, to);
        std::copy_n(sphere.velocity.component.begin(), Dim, to + Dim);
        std::copy_n(sphere.spin.component.begin(), rotation, to + 2 * Dim);
    }
    template <class T>
    [[nodiscard]] BondState<Dim, T> bond(const T* state, int j) const {
        const T* from = state + bond_offset(j);
        BondState<Dim, T> bond;
        std::copy_n(from, rotation, bond.shear_force.component.begin());
        std::copy_n(from + rotation, rotation, bond.moment.component.begin());
        return bond;
    }
    template <class T>
    void set_bond(T* state, int j, const BondState<Dim, T>& bond) const {
        T* to = state + bond_offset(j);
        std::copy_n(bond.shear_force.component.begin(), rotation, to);
        std::copy_n(bond.moment.component.begin(), rotation, to + rotation);
    }

    template <class T>
    [[nodiscard]] BondGeometry<Dim, T> geometry(const T* state, int j) const {
        const T* from = state + geometry_offset(j);
        BondGeometry<Dim, T> geometry;
        geometry.length = from[0];
        std::copy_n(from + 1, Dim, geometry.direction.component.begin());
        return geometry;
    }
    template <class T>
    void set_geometry(T* state, int j, const BondGeometry<Dim, T>& geometry) const {
        T* to = state + geometry_offset(j);
        to[0] = geometry.length;
        std::copy_n(geometry.direction.component.begin(), Dim, to + 1);
    }
    /// Lengths and directions of all bonds from the positions.
    template <class T>
    void set_geometry(T* state) const {
        for (int j = 0; j < bond_count(); ++j) {
            const BondFrame<Dim, T> frame(sphere(state, j + 1).position -
                                          sphere(state, j).position);
            set_geometry(state, j, BondGeometry<Dim, T>{frame.length(), frame.direction()});
        }
    }

    template <class T>
    [[nodiscard]] Rotational<Dim, T> branch_moment(const T* state, int j, int branch) const {
        Rotational<Dim, T> moment;
        std::copy_n(state + branch_offset(j) + static_cast<std::size_t>(branch) * rotation,
                    rotation, moment.component.begin());
        return moment;
    }
    template <class T>
    void set_branch_moment(T* state, int j, int branch, const Rotational<Dim, T>& moment) const {
        std::copy_n(moment.component.begin(), rotation,
                    state + branch_offset(j) + static_cast<std::size_t>(branch) * rotation);
    }

  private:
    int sphere_count_;
    int branch_count_;
    bool base_turns_;
    bool base_slips_;
};

} // namespace culm::physics
