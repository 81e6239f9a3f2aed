// SPDX-License-Identifier: BSD-3-Clause
// Forces on single spheres from support and finger, and the clamp's moment with its derivatives.
#pragma once

#include "physics/chain_model.hpp"

#include <cmath>

namespace culm::physics {

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

/// Sideways force of the finger on the tip, N.
template <class T>
[[nodiscard]] T finger_force(const GradualRelease<T>& release, const T& time) {
    using std::max;
    using std::min;
    const T progress = max(T(0.0), min(T(1.0), time / release.duration));
    return release.holding_force * (T(1.0) - progress * progress * (T(3.0) - T(2.0) * progress));
}

} // namespace culm::physics
