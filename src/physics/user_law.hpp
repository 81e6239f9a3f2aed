// SPDX-License-Identifier: BSD-3-Clause
// A force or moment that a user wrote as an expression.
#pragma once

#include "core/lanes.hpp"

#include <concepts>
#include <cstddef>
#include <functional>
#include <memory>
#include <span>
#include <stdexcept>
#include <vector>

namespace culm::physics {

enum class UserLawKind {
    ForcePerLength, ///< on the stem, sideways toward the pull, N/m
    BendingMoment,  ///< added to the elastic moment, with the sign of the curvature, N m
    BaseMoment,     ///< on the stem at the clamp, which then turns, N m
};

/// Inputs of an expression. `position` is along the stem from the clamp, m; `deflection` (m) and
/// `velocity` (m/s) are sideways; `curvature` 1/m and its rate 1/(m s). For a base moment
/// deflection and velocity are the clamp's rotation (rad) and its rate (rad/s).
/// T is a double, or SIMD lanes.
template <class T>
struct UserLawInputsOf {
    T position = T(0.0);
    T deflection = T(0.0);
    T velocity = T(0.0);
    T curvature = T(0.0);
    T curvature_rate = T(0.0);
    T time = T(0.0);
};
using UserLawInputs = UserLawInputsOf<double>;

/// A compiled expression; calling it with inputs and the values of its parameters gives the force
/// per length or the moment. Throws core::NumericalError (UserExpression) if that is not a number.
using UserExpression =
    std::function<double(const UserLawInputs& inputs, std::span<const double> parameters)>;

template <class T>
struct UserLaw {
    UserLawKind kind = UserLawKind::ForcePerLength;
    std::shared_ptr<const UserExpression> expression;
    std::vector<T> parameters;
};

/// Value of a user's law in every lane.
template <class T>
[[nodiscard]] T user_law_value(const UserLaw<T>& law, const UserLawInputsOf<T>& inputs) {
    if constexpr (!std::same_as<T, double> && !std::same_as<T, core::Lanes>)
        throw std::logic_error("an expression has no dual numbers; use its slopes");
    else {
        std::vector<double> parameters(law.parameters.size());
        return core::by_lane<T>([&](std::size_t lane) {
            for (std::size_t k = 0; k < parameters.size(); ++k)
                parameters[k] = core::lane(law.parameters[k], lane);
            return (*law.expression)(
                {core::lane(inputs.position, lane), core::lane(inputs.deflection, lane),
                 core::lane(inputs.velocity, lane), core::lane(inputs.curvature, lane),
                 core::lane(inputs.curvature_rate, lane), core::lane(inputs.time, lane)},
                parameters);
        });
    }
}

/// ∂(value)/∂(one input) by a central difference, since an expression has no analytic derivatives.
/// `size` is a large value of that input.
template <class T>
[[nodiscard]] T user_law_slope(const UserLaw<T>& law, UserLawInputsOf<T> inputs,
                               T UserLawInputsOf<T>::*input, double size) {
    const T at = inputs.*input;
    const T change = T(1e-6 * size);
    inputs.*input = at + change;
    const T above = user_law_value(law, inputs);
    inputs.*input = at - change;
    return (above - user_law_value(law, inputs)) / (T(2.0) * change);
}

} // namespace culm::physics
