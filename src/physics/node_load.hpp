// SPDX-License-Identifier: BSD-3-Clause
// Forces on single spheres from outside the chain, and the clamp's moment, with their derivatives.
#pragma once

#include "physics/chain_model.hpp"

#include <array>
#include <cmath>

namespace culm::physics {

/// Force on a sphere and its derivatives.
template <int Dim, class T>
struct NodeLoad {
    Vec<Dim, T> force = Vec<Dim, T>::zero(); ///< N
    /// ∂force/∂velocity, one vector a component of the velocity, N s/m
    std::array<Vec<Dim, T>, static_cast<std::size_t>(Dim)> by_velocity{};
    T by_deflection = T(0.0); ///< ∂force/∂position, both sideways, N/m
};

/// −(c + q|v|) v and its derivatives −(c + q|v|) 1 − q v vᵀ/|v|.
template <int Dim, class T>
void add_air_drag(const AirDrag<T>& drag, const Vec<Dim, T>& velocity, NodeLoad<Dim, T>& load) {
    using std::sqrt;
    // Far below any speed that a camera sees; keeps the root's derivative finite at rest.
    const T floor = T(1e-18);
    const T speed = sqrt(dot(velocity, velocity) + floor);
    const T resistance = drag.linear + drag.quadratic * speed;
    load.force -= resistance * velocity;
    for (int k = 0; k < Dim; ++k) {
        auto& column = load.by_velocity[static_cast<std::size_t>(k)];
        column -= (drag.quadratic * velocity[k] / speed) * velocity;
        column[k] = column[k] - resistance;
    }
}

/// Moment of the clamp on sphere 0 and its derivatives.
template <class T>
struct HingeMoment {
    T moment = T(0.0);      ///< N m
    T by_rotation = T(0.0); ///< N m/rad
    T by_rate = T(0.0);     ///< N m s/rad
};

/// −k θ − M tanh(ω/ω_r), in a form that does not overflow.
template <class T>
[[nodiscard]] HingeMoment<T> hinge_moment(const BaseHinge<T>& hinge, const T& rotation,
                                          const T& rate) {
    using std::abs;
    using std::exp;
    const T ratio = rate / hinge.friction_rate;
    const T decayed = exp(T(-2.0) * abs(ratio));
    const T magnitude = (T(1.0) - decayed) / (T(1.0) + decayed);
    const T slope = (T(1.0) - magnitude * magnitude) * hinge.friction_moment / hinge.friction_rate;
    // |x| tanh|x|/x would be undefined at rest; tanh x ≈ x there.
    const T towards = ratio / (abs(ratio) + T(1e-300));
    return {-hinge.stiffness * rotation - hinge.friction_moment * magnitude * towards,
            -hinge.stiffness, -slope};
}

/// Where the support is, m, aside of its middle.
template <class T>
[[nodiscard]] T base_position(const BaseMotion<T>& motion, const T& time) {
    using std::sin;
    return motion.amplitude * sin(motion.angular_frequency * time + motion.phase);
}

/// Acceleration that the chain feels in the frame of its support, −ẍ_b, m/s².
template <class T>
[[nodiscard]] T base_acceleration(const BaseMotion<T>& motion, const T& time) {
    return motion.angular_frequency * motion.angular_frequency * base_position(motion, time);
}

/// Sideways force of the finger on the tip, N.
template <class T>
[[nodiscard]] T finger_force(const GradualRelease<T>& release, const T& time) {
    using std::max;
    using std::min;
    const T progress = max(T(0.0), min(T(1.0), time / release.duration));
    return release.holding_force * (T(1.0) - progress * progress * (T(3.0) - T(2.0) * progress));
}

} // namespace culm::physics
