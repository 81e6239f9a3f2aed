// SPDX-License-Identifier: BSD-3-Clause
// ARKODE and CVODE as one class: equations in, one step at a time out.
#pragma once

#include "integrate/sundials/compat.hpp"
#include "integrate/sundials/parts.hpp"

#include <optional>
#include <string>

namespace culm::integrate::sundials {

/// Those functions of ARKODE and CVODE that differ in their names only.
struct SteppingFunctions;

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

/// What a stepper is made of; everything must outlive it.
struct StepperParts {
    SUNContext context;
    N_Vector state; ///< any one of the right size
    SUNMatrix matrix;
    SUNLinearSolver solver;
    CallbackData& data;
};

/// One of SUNDIALS' integrators with its memory; restarted for every case.
class Stepper {
  public:
    /// ARKODE's diagonally implicit Runge-Kutta methods; `table` is the name of a Butcher table, or
    /// empty for the one of choice. Throws core::NumericalError(SolverFailed), as restart() does.
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

    std::unique_ptr<StepControl> control_; ///< of ARKODE; outlives the memory that refers to it
    std::unique_ptr<void, Deleter> memory_;
    const SteppingFunctions* functions_;
};

} // namespace culm::integrate::sundials
