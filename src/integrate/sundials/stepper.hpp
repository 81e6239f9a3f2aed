// SPDX-License-Identifier: BSD-3-Clause
// ARKODE as a class that advances equations step by step, and the objects that SUNDIALS requires:
// vectors, the Newton matrix with its solver, and callbacks.
#pragma once

#include "integrate/solve_summary.hpp"
#include "integrate/sundials/compat.hpp"

#include <cstddef>
#include <exception>
#include <memory>
#include <span>
#include <string>

#include <sundials/sundials_linearsolver.h>
#include <sundials/sundials_matrix.h>
#include <sundials/sundials_nvector.h>

namespace culm::integrate::sundials {

/// The functions of a chain that an integrator calls. Arrays are in the chain's state layout.
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

/// The data that SUNDIALS passes to its callbacks. Exceptions must not pass through SUNDIALS: they
/// are stored here.
struct CallbackData {
    Equations* equations = nullptr; ///< of the case being integrated
    SolveSummary work;              ///< evaluations, factorisations and solves are counted here
    std::exception_ptr exception;
};

using Vector = std::unique_ptr<std::remove_pointer_t<N_Vector>, Deleter<N_VDestroy>>;
using Matrix = std::unique_ptr<std::remove_pointer_t<SUNMatrix>, Deleter<SUNMatDestroy>>;
using LinearSolver =
    std::unique_ptr<std::remove_pointer_t<SUNLinearSolver>, Deleter<SUNLinSolFree>>;

/// ARKODE with all objects that it needs; restarted for every case.
class Stepper {
  public:
    /// For states of `size` numbers: ARKODE's diagonally implicit Runge-Kutta methods, with the
    /// Butcher table of that name (empty: the default). Throws core::NumericalError(SolverFailed),
    /// as restart() does.
    explicit Stepper(std::size_t size, const std::string& table = {});
    Stepper(const Stepper&) = delete; // SUNDIALS keeps the address of the callbacks' data
    Stepper& operator=(const Stepper&) = delete;

    /// Start of the next case, and then the end of each step.
    [[nodiscard]] std::span<double> state() const;
    /// Begins at t = 0 with the first and the longest step, s; infinite: unbounded. `equations`
    /// must live until the last step.
    void restart(Equations& equations, double first, double longest);
    /// One step of the integrator's own choice in the direction of `until`, s; sets the time of its
    /// end. Returns SUNDIALS' flag, negative if it failed. Throws what the equations throw.
    [[nodiscard]] int step(double until, double& time);
    /// Since the restart.
    [[nodiscard]] SolveSummary work() const;
    /// SUNDIALS' name of a flag: "ARK_CONV_FAILURE".
    [[nodiscard]] std::string flag_name(int flag) const;

  private:
    struct FreeMemory {
        void operator()(void* arkode) const { CULM_ARKODE(Free)(&arkode); }
    };

    // In the order in which they depend on one another; the memory refers to all of them.
    Context context_;
    CallbackData data_;
    Vector state_;
    Matrix matrix_;
    LinearSolver linear_solver_;
    StepControl control_;
    std::unique_ptr<void, FreeMemory> memory_;
};

} // namespace culm::integrate::sundials
