// SPDX-License-Identifier: BSD-3-Clause
// The Newton system of a chain as the matrix and the linear solver that SUNDIALS asks for.
#pragma once

#include "integrate/sundials/stepper.hpp"

#include <memory>
#include <type_traits>

#include <sundials/sundials_context.h>
#include <sundials/sundials_linearsolver.h>
#include <sundials/sundials_matrix.h>

namespace culm::integrate::sundials {

/// SUNDIALS' context of one integrator; everything else of SUNDIALS is freed before it.
class Context {
  public:
    /// Throws core::NumericalError(SolverFailed).
    Context();
    ~Context();
    Context(const Context&) = delete;
    Context& operator=(const Context&) = delete;
    [[nodiscard]] SUNContext get() const { return context_; }

  private:
    SUNContext context_;
};

template <auto Free>
struct Deleter {
    template <class T>
    void operator()(T* object) const {
        Free(object);
    }
};
using Matrix = std::unique_ptr<std::remove_pointer_t<SUNMatrix>, Deleter<SUNMatDestroy>>;
using LinearSolver =
    std::unique_ptr<std::remove_pointer_t<SUNLinearSolver>, Deleter<SUNLinSolFree>>;

/// A SUNMatrix that stands for I − γJ of a chain. It holds no numbers itself: the chain's
/// CondensedNewton does, which the linear-system function of the integrator fills.
[[nodiscard]] Matrix newton_matrix(const Context& context);

/// The direct solver for newton_matrix(): the factorisation is made with the matrix, so that only
/// the solve remains, by the equations in `data`, which must outlive it.
[[nodiscard]] LinearSolver newton_solver(CallbackData& data, const Context& context);

} // namespace culm::integrate::sundials
