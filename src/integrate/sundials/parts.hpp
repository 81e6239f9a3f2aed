// SPDX-License-Identifier: BSD-3-Clause
// What a chain looks like to SUNDIALS: vectors, the Newton matrix and its solver, and callbacks.
#pragma once

#include "integrate/solve_summary.hpp"

#include <cstddef>
#include <exception>
#include <memory>
#include <span>
#include <type_traits>

#include <sundials/sundials_context.h>
#include <sundials/sundials_linearsolver.h>
#include <sundials/sundials_matrix.h>
#include <sundials/sundials_nvector.h>

namespace culm::integrate::sundials {

/// What an integrator asks of a chain. Arrays are in the chain's state layout.
class Equations {
  public:
    Equations() = default;
    Equations(const Equations&) = delete;
    Equations& operator=(const Equations&) = delete;
    virtual ~Equations() = default;

    /// dy/dt at `time`, s.
    virtual void evaluate_rate(double time, const double* state, double* rate) = 0;
    /// Evaluates the Jacobian J of the rate.
    virtual void evaluate_jacobian(double time, const double* state) = 0;
    /// Factorises I − γJ; false if that is singular.
    virtual bool factorise(double gamma) = 0;
    /// Solves (I − γJ) x = b.
    virtual void solve(const double* b, double* x) = 0;
    /// Reciprocal allowed errors w: a step is accepted if √(mean of (w e)²) ≤ 1.
    [[nodiscard]] virtual std::span<const double> weights() const = 0;
};

/// What SUNDIALS hands back to its callbacks. Exceptions must not pass through SUNDIALS: they wait
/// here.
struct CallbackData {
    Equations* equations = nullptr; ///< of the case being integrated
    SolveSummary work;              ///< evaluations, factorisations and solves are counted here
    std::exception_ptr exception;
};

/// Callback: the rate of `state`. Positive: try a shorter step; negative: give up.
int evaluate_rate(double time, N_Vector state, N_Vector rate, void* callback_data);
/// Callback: I − γJ, with the Jacobian at hand if that is usable.
int set_up_newton(double time, N_Vector state, bool jacobian_is_usable, double gamma,
                  void* callback_data);
/// Callback: the weights of the errors.
int set_weights(N_Vector state, N_Vector weights, void* callback_data);

template <auto Free>
struct Deleter {
    template <class T>
    void operator()(T* object) const {
        Free(object);
    }
};
using Vector = std::unique_ptr<std::remove_pointer_t<N_Vector>, Deleter<N_VDestroy>>;
using Matrix = std::unique_ptr<std::remove_pointer_t<SUNMatrix>, Deleter<SUNMatDestroy>>;
using LinearSolver =
    std::unique_ptr<std::remove_pointer_t<SUNLinearSolver>, Deleter<SUNLinSolFree>>;

/// A vector of `size` zeros. Debian compiles SUNDIALS without optimisation: with its own serial
/// vectors, four fifths of a run pass in sums of arrays.
[[nodiscard]] Vector make_vector(std::size_t size, SUNContext context);

/// The numbers of a vector that make_vector() made, or of a clone of one.
[[nodiscard]] std::span<double> values(N_Vector vector);

/// A SUNMatrix that stands for I − γJ of a chain. It holds no numbers itself: the equations do,
/// whose factorisation set_up_newton() asks for.
[[nodiscard]] Matrix newton_matrix(SUNContext context);

/// The direct solver for newton_matrix(): the factorisation is made with the matrix, so that only
/// the solve remains. `data` must outlive it.
[[nodiscard]] LinearSolver newton_solver(CallbackData& data, SUNContext context);

} // namespace culm::integrate::sundials
