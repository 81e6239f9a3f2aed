// SPDX-License-Identifier: BSD-3-Clause
// The direction of a bond, and how shear forces and moments are expressed and turned with it.
//
// In the plane the shear force and the moment are scalars: the shear force acts along the bond's
// normal t = (−n_y, n_x), the moment about z, and neither changes when the bond turns.
// In space both are vectors in world axes, which have to be turned with the bond.
// The bond law (bond_law.hpp) is written once in terms of these operations.
#pragma once

#include "core/lanes.hpp"
#include "core/vec.hpp"

namespace culm::physics {

using core::Vec;

/// Numbers that a shear force, a moment or a spin has in 2 and in 3 dimensions.
template <int Dim>
inline constexpr int rotation_dimension = Dim == 2 ? 1 : 3;

/// Shear force, moment or angular velocity: one number in the plane, three in space.
template <int Dim, class T>
using Rotational = Vec<rotation_dimension<Dim>, T>;

/// The line from sphere 1 to sphere 2.
template <int Dim, class T>
class BondLine {
  public:
    explicit BondLine(const Vec<Dim, T>& separation) {
        const T square = dot(separation, separation);
        const T inverse = core::inverse_sqrt(square);
        length_ = square * inverse;
        direction_ = inverse * separation;
    }
    /// `direction` need not be a unit vector.
    BondLine(const T& length, const Vec<Dim, T>& direction) : length_(length) {
        direction_ = core::inverse_sqrt(dot(direction, direction)) * direction;
    }
    [[nodiscard]] const T& length() const { return length_; }
    /// Unit vector n from sphere 1 to sphere 2.
    [[nodiscard]] const Vec<Dim, T>& direction() const { return direction_; }

  protected:
    T length_;
    Vec<Dim, T> direction_;
};

template <int Dim, class T>
class BondFrame;

/// A bond in the plane.
template <class T>
class BondFrame<2, T> : public BondLine<2, T> {
  public:
    using BondLine<2, T>::BondLine;

    /// The part of `v` across the bond.
    [[nodiscard]] Rotational<2, T> transverse(const Vec<2, T>& v) const {
        return {{cross(direction_, v)}};
    }
    /// A transverse quantity as a vector in world axes.
    [[nodiscard]] Vec<2, T> to_world(const Rotational<2, T>& q) const {
        return {{-(q[0] * direction_[1]), q[0] * direction_[0]}};
    }
    /// Transverse velocity that a spin gives to a point at unit distance along n: ω × n.
    [[nodiscard]] Rotational<2, T> spin_velocity(const Rotational<2, T>& spin) const {
        return spin;
    }
    /// Moment of a transverse force at unit distance along n: n × F.
    [[nodiscard]] Rotational<2, T> moment_of(const Rotational<2, T>& force) const { return force; }
    /// The twisting part of `q`, of which there is none in the plane, times one factor plus the
    /// bending part times the other.
    [[nodiscard]] Rotational<2, T> scaled(const T&, const T& bending,
                                          const Rotational<2, T>& q) const {
        return bending * q;
    }

    /// Rates by which stored forces and moments turn with the bond: none in the plane.
    [[nodiscard]] Rotational<2, T> shear_turning_rate(const Rotational<2, T>&,
                                                      const Vec<2, T>&) const {
        return {{T(0.0)}};
    }
    [[nodiscard]] Rotational<2, T> moment_turning_rate(const Rotational<2, T>&,
                                                       const Vec<2, T>&) const {
        return {{T(0.0)}};
    }
    /// Finite turns from an older direction to this one.
    [[nodiscard]] Rotational<2, T> turned_shear(const Rotational<2, T>& force) const {
        return force;
    }
    [[nodiscard]] Rotational<2, T> turned_moment(const Rotational<2, T>& moment,
                                                 const Vec<2, T>&) const {
        return moment;
    }

  private:
    using BondLine<2, T>::direction_;
};

/// A bond in space.
template <class T>
class BondFrame<3, T> : public BondLine<3, T> {
  public:
    using BondLine<3, T>::BondLine;

    [[nodiscard]] Rotational<3, T> transverse(const Vec<3, T>& v) const {
        return v - dot(v, direction_) * direction_;
    }
    [[nodiscard]] Vec<3, T> to_world(const Rotational<3, T>& q) const { return q; }
    [[nodiscard]] Rotational<3, T> spin_velocity(const Rotational<3, T>& spin) const {
        return cross(spin, direction_);
    }
    [[nodiscard]] Rotational<3, T> moment_of(const Rotational<3, T>& force) const {
        return cross(direction_, force);
    }
    [[nodiscard]] Rotational<3, T> scaled(const T& twisting, const T& bending,
                                          const Rotational<3, T>& q) const {
        return bending * q + ((twisting - bending) * dot(q, direction_)) * direction_;
    }

    /// Limit of the reference code's "project on the plane normal to n, keep the length":
    /// dF/dt = −(F·ṅ) n, with ṅ the transverse relative velocity over the length.
    [[nodiscard]] Rotational<3, T> shear_turning_rate(const Rotational<3, T>& force,
                                                      const Vec<3, T>& velocity) const {
        const Vec<3, T> direction_rate = (T(1.0) / length_) * transverse(velocity);
        return -(dot(force, direction_rate)) * direction_;
    }
    /// The bond's turn without twist: dM/dt = (n × ṅ) × M.
    [[nodiscard]] Rotational<3, T> moment_turning_rate(const Rotational<3, T>& moment,
                                                       const Vec<3, T>& velocity) const {
        const Vec<3, T> direction_rate = (T(1.0) / length_) * transverse(velocity);
        return cross(cross(direction_, direction_rate), moment);
    }
    [[nodiscard]] Rotational<3, T> turned_shear(const Rotational<3, T>& force) const {
        return rescaled(transverse(force), dot(force, force));
    }
    /// The twist is laid along the new direction, the bending moment into its normal plane; both
    /// keep their magnitude. `old_direction` determines which part was twist.
    [[nodiscard]] Rotational<3, T> turned_moment(const Rotational<3, T>& moment,
                                                 const Vec<3, T>& old_direction) const {
        const T twisting = dot(moment, old_direction);
        const Vec<3, T> bending = moment - twisting * old_direction;
        return twisting * direction_ + rescaled(transverse(bending), dot(bending, bending));
    }

  private:
    /// `v` scaled to the length √`target_square`. The floor only prevents a NaN from 0/0; it is far
    /// below any force or moment (N, N m) that is significant in double precision.
    [[nodiscard]] static Vec<3, T> rescaled(const Vec<3, T>& v, const T& target_square) {
        const T floor = T(1e-60);
        const T target = target_square + floor;
        return (target * core::inverse_sqrt(target * (dot(v, v) + floor))) * v;
    }

    using BondLine<3, T>::direction_;
    using BondLine<3, T>::length_;
};

} // namespace culm::physics
