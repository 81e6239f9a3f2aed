// SPDX-License-Identifier: BSD-3-Clause
// Where the numbers of a chain's state stand in a flat array.
#pragma once

#include "physics/bond_law.hpp"

#include <algorithm>
#include <cstddef>

namespace culm::physics {

/// One sphere's share of the state.
template <int Dim, class T>
struct SphereState {
    Vec<Dim, T> position;    ///< m; axis 0 points from the clamp along the stem, axis 1 to the pull
    Vec<Dim, T> velocity;    ///< m/s
    Rotational<Dim, T> spin; ///< rad/s
};

/// The flat state: first every sphere (position, velocity, spin), from the clamp to the tip, then
/// every bond (elastic shear force, elastic moment). That is 7 numbers a link in the plane and 15
/// in space. Rotation angles of the spheres are not states. The same layout holds the rates.
template <int Dim>
class ChainLayout {
  public:
    static constexpr int rotation = rotation_dimension<Dim>;
    static constexpr int sphere_size = 2 * Dim + rotation;
    static constexpr int bond_size = 2 * rotation;

    explicit ChainLayout(int sphere_count) : sphere_count_(sphere_count) {}

    [[nodiscard]] int sphere_count() const { return sphere_count_; }
    [[nodiscard]] int bond_count() const { return sphere_count_ - 1; }
    [[nodiscard]] std::size_t size() const { return bond_offset(bond_count()); }

    [[nodiscard]] std::size_t sphere_offset(int sphere) const {
        return static_cast<std::size_t>(sphere) * sphere_size;
    }
    /// Bond `bond` joins spheres `bond` and `bond + 1`.
    [[nodiscard]] std::size_t bond_offset(int bond) const {
        return static_cast<std::size_t>(sphere_count_) * sphere_size +
               static_cast<std::size_t>(bond) * bond_size;
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

  private:
    int sphere_count_;
};

} // namespace culm::physics
