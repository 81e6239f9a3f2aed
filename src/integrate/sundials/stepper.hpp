// SPDX-License-Identifier: BSD-3-Clause
// ARKODE and CVODE behind one interface: equations in, one step at a time out.
#pragma once

#include "integrate/solve_summary.hpp"
#include "integrate/sundials/vector.hpp"

#include <exception>
#include <memory>
#include <span>
#include <string>

#include <sundials/sundials_linearsolver.h>
#include <sundials/sundials_matrix.h>

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
    /// Reciprocal allowed errors e: a step is accepted if √(mean of (w e)²) ≤ 1.
    [[nodiscard]] virtual std::span<const double> weights() const = 0;
};

/// What SUNDIALS hands back to its callbacks. Exceptions must not pass through SUNDIALS: they wait
/// here.
struct CallbackData {
    Equations* equations = nullptr; ///< of the case being integrated
    SolveSummary work;              ///< evaluations, factorisations and solves are counted here
    std::exception_ptr exception;
};

/// The bounds of one case's steps, s.
struct StepBounds {
    double first = 0.0;
    double longest = 0.0; ///< infinite if unbounded
};

/// How a step of SUNDIALS ended: its flag, and where it is now.
struct StepEnd {
    int flag = 0;      ///< negative: it failed
    double time = 0.0; ///< s
};

/// One of SUNDIALS' integrators with its memory; restarted for every case.
class Stepper {
  public:
    Stepper() = default;
    Stepper(const Stepper&) = delete;
    Stepper& operator=(const Stepper&) = delete;
    virtual ~Stepper() = default;

    /// Begins at t = 0. Throws core::NumericalError(SolverFailed).
    virtual void restart(N_Vector state, const StepBounds& bounds) = 0;
    /// One step of the integrator's own choice in the direction of `until`, s; `state` is its end.
    virtual StepEnd step(double until, N_Vector state) = 0;
    /// Steps, failed error tests and failed iterations since the restart are added to `work`.
    virtual void add_counts(SolveSummary& work) const = 0;
    /// SUNDIALS' name of a flag: "ARK_CONV_FAILURE".
    [[nodiscard]] virtual std::string flag_name(int flag) const = 0;
};

/// What a stepper is made of; everything must outlive it.
struct StepperParts {
    SUNContext context;
    N_Vector state; ///< any one of the right size
    SUNMatrix matrix;
    SUNLinearSolver solver;
    CallbackData& data;
};

/// ARKODE's diagonally implicit Runge-Kutta methods; `table` is the name of a Butcher table, or
/// empty for the one of choice. Throws core::NumericalError(SolverFailed).
[[nodiscard]] std::unique_ptr<Stepper> make_arkode(const StepperParts& parts,
                                                   const std::string& table);
/// CVODE's backward differentiation formulas. Throws core::NumericalError(SolverFailed).
[[nodiscard]] std::unique_ptr<Stepper> make_cvode(const StepperParts& parts);

/// Callback: the rate of `state`. Positive: try a shorter step; negative: give up.
int evaluate_rate(double time, N_Vector state, N_Vector rate, void* callback_data);
/// Callback: I − γJ, with the Jacobian at hand if that is usable.
int set_up_newton(double time, N_Vector state, bool jacobian_is_usable, double gamma,
                  void* callback_data);
/// Callback: the weights of the errors.
int set_weights(N_Vector state, N_Vector weights, void* callback_data);

/// Throws core::NumericalError(SolverFailed) when a set-up call of SUNDIALS reports an error.
void check(int flag, const char* call);

} // namespace culm::integrate::sundials
