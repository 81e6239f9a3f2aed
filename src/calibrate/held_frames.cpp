// SPDX-License-Identifier: BSD-3-Clause
#include "calibrate/held_frames.hpp"

#include "physics/node_load.hpp"

#include <algorithm>
#include <cmath>

namespace culm::calibrate {
namespace {

/// Of a parameter's size. The support's path is smooth: the error of a central difference is the
/// square of this, that of rounding 1e-16 over it.
constexpr double relative_step = 1e-5;

} // namespace

HeldFrames::HeldFrames(const StemModel& model)
    : free_length_(model.spec.stem.free_length()), case_(run::case_model(model.spec)) {
    if (!move())
        return;
    for (const FreeParameter& parameter : model.parameters) {
        const double value = parameter.access.get(model.spec);
        const double size = std::max(std::abs(value), parameter.access.scale);
        run::CaseSpec below = model.spec;
        run::CaseSpec above = model.spec;
        parameter.access.set(below, value - relative_step * size);
        parameter.access.set(above, value + relative_step * size);
        neighbours_.push_back(
            {run::case_model(below), run::case_model(above), 2.0 * relative_step * size});
    }
}

double HeldFrames::shift_of(const run::CaseModel& model, double time, double height) const {
    const physics::BaseMotion<double>& base = *model.chain.base_motion;
    return (physics::base_position(base, time) - physics::base_position(base, 0.0)) *
           (1.0 + model.camera.scale_change * height / free_length_);
}

double HeldFrames::shift(double time, double height) const {
    return move() ? shift_of(case_, time, height) : 0.0;
}

double HeldFrames::derivative(std::size_t parameter, double time, double height) const {
    if (!move())
        return 0.0;
    const Neighbours& pair = neighbours_[parameter];
    return (shift_of(pair.above, time, height) - shift_of(pair.below, time, height)) /
           pair.distance;
}

double HeldFrames::rate(double time, double height) const {
    if (!move())
        return 0.0;
    const double step = relative_step / case_.chain.base_motion->angular_frequency;
    return (shift_of(case_, time + step, height) - shift_of(case_, time - step, height)) /
           (2.0 * step);
}

} // namespace culm::calibrate
