// SPDX-License-Identifier: BSD-3-Clause
#include "reduce/ring_down_model.hpp"

#include <cmath>
#include <numbers>

namespace culm::reduce {

namespace {}

RingDownPoint evaluate_ring_down(const RingDownParameters& parameters, double time) {
    const double envelope = std::exp(parameters.decay_rate * time);
    const double phase = two_pi * parameters.frequency * time;
    const double in_phase = envelope * std::cos(phase);
    const double quadrature = envelope * std::sin(phase);
    RingDownPoint point;
    point.value = parameters.amplitude * in_phase;
    point.gradient = {in_phase, time * point.value,
                      -two_pi * time * parameters.amplitude * quadrature};
    return point;
}

Eigen::Matrix3d ring_down_hessian(const RingDownParameters& parameters, double time,
                                  const Eigen::Vector3d& gradient) {
    const double value = parameters.amplitude * gradient[0];
    // e^(b1 t) sin(2π b2 t) times −2π t: the gradient by b2 without its amplitude, which may be 0.
    const double turn = -two_pi * time * std::exp(parameters.decay_rate * time) *
                        std::sin(two_pi * parameters.frequency * time);
    Eigen::Matrix3d hessian;
    hessian(0, 0) = 0.0;
    hessian(0, 1) = hessian(1, 0) = time * gradient[0];
    hessian(0, 2) = hessian(2, 0) = turn;
    hessian(1, 1) = time * time * value;
    hessian(1, 2) = hessian(2, 1) = time * gradient[2];
    hessian(2, 2) = -two_pi * two_pi * time * time * value;
    return hessian;
}

} // namespace culm::reduce
