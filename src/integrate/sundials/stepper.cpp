// SPDX-License-Identifier: BSD-3-Clause
#include "integrate/sundials/stepper.hpp"

#include "core/error.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/core.h>

namespace culm::integrate::sundials {
namespace {

constexpr int shorter_step = 1; ///< SUNDIALS' code of a failure that a shorter step may mend
constexpr int give_up = -1;

bool all_finite(std::span<const double> numbers) {
    double sum = 0.0; // x − x is 0 for every number and NaN for what is none
    for (const double number : numbers)
        sum += number - number;
    return sum == 0.0;
}

/// Runs one callback; its exception waits until SUNDIALS has returned.
template <class F>
int guarded(void* callback_data, F&& callback) {
    auto& data = *static_cast<CallbackData*>(callback_data);
    try {
        return callback(data);
    } catch (...) {
        data.exception = std::current_exception();
        return give_up;
    }
}

} // namespace

int evaluate_rate(double time, N_Vector state, N_Vector rate, void* callback_data) {
    return guarded(callback_data, [&](CallbackData& data) {
        ++data.work.rhs_evaluations;
        data.equations->evaluate_rate(time, values(state).data(), values(rate).data());
        return all_finite(values(rate)) ? 0 : shorter_step;
    });
}

int set_up_newton(double time, N_Vector state, bool jacobian_is_usable, double gamma,
                  void* callback_data) {
    return guarded(callback_data, [&](CallbackData& data) {
        if (!jacobian_is_usable) {
            data.equations->evaluate_jacobian(time, values(state).data());
            ++data.work.jacobian_evaluations;
        }
        ++data.work.factorisations;
        return data.equations->factorise(gamma) ? 0 : shorter_step;
    });
}

int set_weights(N_Vector, N_Vector weights, void* callback_data) {
    const auto& data = *static_cast<const CallbackData*>(callback_data);
    std::ranges::copy(data.equations->weights(), values(weights).begin());
    return 0;
}

void check(int flag, const char* call) {
    if (flag < 0)
        throw core::NumericalError(core::FailureKind::SolverFailed,
                                   fmt::format("{} of SUNDIALS failed with flag {}", call, flag));
}

} // namespace culm::integrate::sundials
