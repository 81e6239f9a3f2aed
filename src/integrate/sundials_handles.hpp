// SPDX-License-Identifier: BSD-3-Clause
// Owners of SUNDIALS objects, and checked calls.
#pragma once

#include "core/error.hpp"

#include <memory>
#include <type_traits>
#include <utility>

#include <fmt/core.h>
#include <nvector/nvector_serial.h>
#include <sundials/sundials_context.h>
#include <sundials/sundials_linearsolver.h>
#include <sundials/sundials_matrix.h>

namespace culm::integrate::sundials {

/// A SUNContext for the lifetime of one integration.
class Context {
  public:
    Context() {
        if (SUNContext_Create(nullptr, &context_) != 0)
            throw core::NumericalError(core::FailureKind::SolverFailed, "SUNDIALS gave no context");
    }
    ~Context() { SUNContext_Free(&context_); }
    Context(const Context&) = delete;
    Context& operator=(const Context&) = delete;
    [[nodiscard]] SUNContext get() const { return context_; }

  private:
    SUNContext context_ = nullptr;
};

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

/// An N_Vector over memory that the caller keeps.
[[nodiscard]] inline Vector view_of(double* data, std::size_t size, const Context& context) {
    return Vector(N_VMake_Serial(static_cast<sunindextype>(size), data, context.get()));
}

/// Throws when a set-up call of SUNDIALS reports an error.
inline void check(int flag, const char* call) {
    if (flag < 0)
        throw core::NumericalError(core::FailureKind::SolverFailed,
                                   fmt::format("{} failed with flag {}", call, flag));
}

} // namespace culm::integrate::sundials
