// SPDX-License-Identifier: BSD-3-Clause
// ARKODE and CVODE as one class that advances equations step by step, and the objects that SUNDIALS
// requires: vectors, the Newton matrix with its solver, and callbacks.
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

/// Callback: the rate of `state`. Positive: try a shorter step; negative: give up.
int evaluate_rate(double time, N_Vector state, N_Vector rate, void* callback_data);
/// Callback: I − γJ, with the current Jacobian if it is usable, else with a new one.
int set_up_newton(double time, N_Vector state, Boolean jacobian_is_usable, Boolean* jacobian_is_new,
                  double gamma, void* callback_data);
/// Callback: the weights of the errors.
int set_weights(N_Vector state, N_Vector weights, void* callback_data);

using Vector = std::unique_ptr<std::remove_pointer_t<N_Vector>, Deleter<N_VDestroy>>;
using Matrix = std::unique_ptr<std::remove_pointer_t<SUNMatrix>, Deleter<SUNMatDestroy>>;
using LinearSolver =
    std::unique_ptr<std::remove_pointer_t<SUNLinearSolver>, Deleter<SUNLinSolFree>>;

/// A vector of `size` zeros. Debian compiles SUNDIALS without optimisation: with its own serial
/// vectors, four fifths of a run pass in sums of arrays.
[[nodiscard]] Vector make_vector(std::size_t size, SUNContext context);

/// The numbers of a vector that make_vector() made, or of a clone of one.
[[nodiscard]] std::span<double> values(N_Vector vector);

/// A SUNMatrix that represents I − γJ of a chain. It contains no numbers: set_up_newton() calls the
/// equations to factorise the matrix.
[[nodiscard]] Matrix newton_matrix(SUNContext context);

/// The direct solver for newton_matrix(). It only solves, because set_up_newton() has factorised
/// the matrix. `data` must outlive it.
[[nodiscard]] LinearSolver newton_solver(CallbackData& data, SUNContext context);

/// The functions of ARKODE and CVODE that differ only in their names.
struct SteppingFunctions;

/// The bounds of one case's steps, s.
struct StepBounds {
    double first = 0.0;
    double longest = 0.0; ///< infinite if unbounded
};

/// The end of a step of SUNDIALS: its flag and time.
struct StepEnd {
    int flag = 0;      ///< negative: it failed
    double time = 0.0; ///< s
};

/// The objects that a stepper uses; they must outlive it.
struct StepperParts {
    SUNContext context;
    N_Vector state; ///< any vector of the right size
    SUNMatrix matrix;
    SUNLinearSolver solver;
    CallbackData& data;
};

/// One of SUNDIALS' integrators with its memory; restarted for every case.
class Stepper {
  public:
    /// ARKODE's diagonally implicit Runge-Kutta methods; `table` is the name of a Butcher table, or
    /// empty for the default. Throws core::NumericalError(SolverFailed), as restart() does.
    [[nodiscard]] static Stepper arkode(const StepperParts& parts, const std::string& table);
    /// CVODE's backward differentiation formulas.
    [[nodiscard]] static Stepper cvode(const StepperParts& parts);

    /// Begins at t = 0.
    void restart(N_Vector state, const StepBounds& bounds);
    /// One step of the integrator's own choice in the direction of `until`, s; `state` is its end.
    [[nodiscard]] StepEnd step(double until, N_Vector state);
    /// Adds steps, failed error tests and failed iterations since the restart to `work`.
    void add_counts(SolveSummary& work) const;
    /// SUNDIALS' name of a flag: "ARK_CONV_FAILURE".
    [[nodiscard]] std::string flag_name(int flag) const;

  private:
    struct Deleter {
        void (*free)(void**) = nullptr;
        void operator()(void* memory) const { free(&memory); }
    };

    Stepper(void* memory, const SteppingFunctions& functions);
    void set_up(const StepperParts& parts);

    StepControl control_; ///< of ARKODE; outlives the memory that refers to it
    std::unique_ptr<void, Deleter> memory_;
    const SteppingFunctions* functions_;
};

} // namespace culm::integrate::sundials
