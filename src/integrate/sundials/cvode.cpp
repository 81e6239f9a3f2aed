// SPDX-License-Identifier: BSD-3-Clause
#include "core/error.hpp"
#include "integrate/sundials/compat.hpp"
#include "integrate/sundials/stepper.hpp"

#include <cmath>
#include <cstdlib>

namespace culm::integrate::sundials {
namespace {

/// The formulas of order 3 and more are unstable for vibrations that are hardly damped: with them
/// the high modes of a stem of low damping limit the step to a fraction of their own period.
constexpr int largest_order = 2;

struct CvodeDeleter {
    void operator()(void* memory) const { CVodeFree(&memory); }
};

int cvode_linear_system(Real time, N_Vector state, N_Vector, SUNMatrix, Boolean jacobian_is_usable,
                        Boolean* jacobian_is_new, Real gamma, void* data, N_Vector, N_Vector,
                        N_Vector) {
    *jacobian_is_new = jacobian_is_usable ? SUNFALSE : SUNTRUE;
    return set_up_newton(time, state, jacobian_is_usable != SUNFALSE, gamma, data);
}

class Cvode final : public Stepper {
  public:
    explicit Cvode(const StepperParts& parts) : memory_(CVodeCreate(CV_BDF, parts.context)) {
        if (!memory_)
            throw core::NumericalError(core::FailureKind::SolverFailed,
                                       "SUNDIALS gave no memory for CVODE");
        void* const cvode = memory_.get();
        check(CVodeInit(cvode, evaluate_rate, 0.0, parts.state), "CVodeInit");
        check(silence_cvode(cvode), "the error handler");
        check(CVodeSetUserData(cvode, &parts.data), "CVodeSetUserData");
        check(CVodeWFtolerances(cvode, set_weights), "CVodeWFtolerances");
        check(CVodeSetLinearSolver(cvode, parts.solver, parts.matrix), "CVodeSetLinearSolver");
        check(CVodeSetLinSysFn(cvode, cvode_linear_system), "CVodeSetLinSysFn");
        check(CVodeSetMaxOrd(cvode, largest_order), "CVodeSetMaxOrd");
    }

    void restart(N_Vector state, const StepBounds& bounds) override {
        void* const cvode = memory_.get();
        check(CVodeReInit(cvode, 0.0, state), "CVodeReInit");
        check(CVodeSetInitStep(cvode, bounds.first), "CVodeSetInitStep");
        check(CVodeSetMaxStep(cvode, std::isfinite(bounds.longest) ? bounds.longest : 0.0),
              "CVodeSetMaxStep");
    }

    StepEnd step(double until, N_Vector state) override {
        StepEnd end;
        end.flag = CVode(memory_.get(), until, state, &end.time, CV_ONE_STEP);
        return end;
    }

    void add_counts(SolveSummary& work) const override {
        long int steps = 0;
        long int error_failures = 0;
        long int convergence_failures = 0;
        CVodeGetNumSteps(memory_.get(), &steps);
        CVodeGetNumErrTestFails(memory_.get(), &error_failures);
        CVodeGetNumStepSolveFails(memory_.get(), &convergence_failures);
        work.steps += steps;
        work.rejected_steps += error_failures;
        work.convergence_failures += convergence_failures;
    }

    [[nodiscard]] std::string flag_name(int flag) const override {
        char* const name = CVodeGetReturnFlagName(flag);
        std::string text(name);
        std::free(name);
        return text;
    }

  private:
    std::unique_ptr<void, CvodeDeleter> memory_;
};

} // namespace

std::unique_ptr<Stepper> make_cvode(const StepperParts& parts) {
    return std::make_unique<Cvode>(parts);
}

} // namespace culm::integrate::sundials
