// SPDX-License-Identifier: BSD-3-Clause
// The moment of a clamp that turns.
//
// Without slip it is −k θ − c ω − M_f tanh(ω/ω_r), with the rotation θ and the rate ω of sphere 0.
// The hyperbolic tangent regularises dry friction, whose sign is undefined at rest.
//
// With slip, −z replaces −k θ (Bouc 1967, Wen 1976): ż = k ω (1 − s |z|ⁿ) while |z| grows and k ω
// while it falls. The joint unloads with its full stiffness and slips more the higher its moment:
// it loses s z0ⁿ⁺² · 2/((n + 2) k) in a cycle of small s z0ⁿ, and softens by a share ~ s z0ⁿ.
#pragma once

#include <cmath>

namespace culm::physics {

template <class T>
struct BaseHinge {
    T stiffness;        ///< k, N m/rad
    T friction_moment;  ///< M_f, N m
    T friction_rate;    ///< ω_r, rad/s; friction is full well above it and creep below
    T damping = T(0.0); ///< c, N m s/rad
};

/// Slip of the clamp's spring, whose moment z is a state.
template <class T>
struct JointSlip {
    T share; ///< s: share of the stiffness that is lost at 1 N m
    T power; ///< n
};

/// The state of a clamp that turns.
template <class T>
struct BaseState {
    T rotation = T(0.0); ///< θ, rad
    T rate = T(0.0);     ///< ω, rad/s
    T moment = T(0.0);   ///< z, N m; of a joint that slips
};

/// Moment of the clamp on sphere 0 and its derivatives.
template <class T>
struct HingeMoment {
    T moment = T(0.0);      ///< N m
    T by_rotation = T(0.0); ///< N m/rad
    T by_rate = T(0.0);     ///< N m s/rad
};

/// −k θ − c ω − M_f tanh(ω/ω_r), in a form that does not overflow.
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
    return {-hinge.stiffness * rotation - hinge.damping * rate -
                hinge.friction_moment * magnitude * towards,
            -hinge.stiffness, -hinge.damping - slope};
}

/// ż and its derivatives.
template <class T>
struct SlipRate {
    T value;     ///< ż, N m/s
    T by_rate;   ///< ∂ż/∂ω, N m/rad
    T by_moment; ///< ∂ż/∂z, 1/s
};

template <class T>
[[nodiscard]] SlipRate<T> slip_rate(const BaseHinge<T>& hinge, const JointSlip<T>& slip,
                                    const T& moment, const T& rate) {
    using std::abs;
    using std::max;
    using std::pow;
    const T tiny = T(1e-300);
    const T work = moment * rate;
    const T size = abs(moment) + tiny;
    // s |z|ⁿ while the moment grows, else 0.
    const T lost = slip.share * pow(size, slip.power) * max(work, T(0.0)) / (abs(work) + tiny);
    return {hinge.stiffness * rate * (T(1.0) - lost), hinge.stiffness * (T(1.0) - lost),
            -hinge.stiffness * abs(rate) * slip.power * lost / size};
}

/// z of a joint that was turned once, from rest to θ, and its slope dz/dθ (Runge and Kutta).
template <class T>
[[nodiscard]] HingeMoment<T> first_turn(const BaseHinge<T>& hinge, const JointSlip<T>& slip,
                                        const T& rotation) {
    constexpr int steps = 32;
    const T step = rotation * T(1.0 / steps);
    const auto slope = [&](const T& moment) {
        return slip_rate(hinge, slip, moment, rotation).by_rate;
    };
    T moment = T(0.0);
    for (int k = 0; k < steps; ++k) {
        const T a = step * slope(moment);
        const T b = step * slope(moment + T(0.5) * a);
        const T c = step * slope(moment + T(0.5) * b);
        const T d = step * slope(moment + c);
        moment = moment + (a + T(2.0) * (b + c) + d) * T(1.0 / 6.0);
    }
    return {moment, slope(moment), T(0.0)};
}

} // namespace culm::physics
