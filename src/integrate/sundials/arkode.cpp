// SPDX-License-Identifier: BSD-3-Clause
#include "core/error.hpp"
#include "integrate/sundials/compat.hpp"
#include "integrate/sundials/stepper.hpp"

#include <cmath>
#include <cstdlib>

namespace culm::integrate::sundials {
namespace {

/// L-stable, stiffly accurate, order 4 with an embedded order 3: Kennedy & Carpenter (2016),
/// NASA/TM-2016-219173. docs/performance.md compares the tables.
constexpr const char* default_table = "ARKODE_ESDIRK436L2SA_6_3_4";
/// ARKODE's number of the predictor that extrapolates the last step's interpolant at full order.
/// Without it the simplified Newton iteration, and not accuracy, limits the step.
constexpr int full_order_predictor = 1;
/// Newton's iteration may err by this share of the step's allowed error. With ARKODE's default of
/// 0.1 the iteration, and not the method, determines the error of b1.
constexpr double newton_share = 0.01;

struct ArkodeDeleter {
    void operator()(void* memory) const { CULM_ARKODE(Free)(&memory); }
};

int arkode_linear_system(Real time, N_Vector state, N_Vector, SUNMatrix, SUNMatrix,
                         Boolean jacobian_is_usable, Boolean* jacobian_is_new, Real gamma,
                         void* data, N_Vector, N_Vector, N_Vector) {
    *jacobian_is_new = jacobian_is_usable ? SUNFALSE : SUNTRUE;
    return set_up_newton(time, state, jacobian_is_usable != SUNFALSE, gamma, data);
}

class Arkode final : public Stepper {
  public:
    Arkode(const StepperParts& parts, const std::string& table)
        : control_(parts.context),
          memory_(ARKStepCreate(nullptr, evaluate_rate, 0.0, parts.state, parts.context)) {
        if (!memory_)
            throw core::NumericalError(core::FailureKind::SolverFailed,
                                       "SUNDIALS gave no memory for ARKODE");
        void* const ark = memory_.get();
        check(silence_arkode(ark), "the error handler");
        check(CULM_ARKODE(SetUserData)(ark, &parts.data), "SetUserData");
        check(ARKStepSetTableName(ark, table.empty() ? default_table : table.c_str(),
                                  "ARKODE_ERK_NONE"),
              "SetTableName");
        check(CULM_ARKODE(WFtolerances)(ark, set_weights), "WFtolerances");
        check(CULM_ARKODE(SetLinearSolver)(ark, parts.solver, parts.matrix), "SetLinearSolver");
        check(CULM_ARKODE(SetLinSysFn)(ark, arkode_linear_system), "SetLinSysFn");
        check(CULM_ARKODE(SetPredictorMethod)(ark, full_order_predictor), "SetPredictorMethod");
        check(CULM_ARKODE(SetNonlinConvCoef)(ark, newton_share), "SetNonlinConvCoef");
        check(control_.attach_to(ark), "SetAdaptController");
        // A stage's rate taken from the right-hand side carries the Newton iteration's error times
        // the stiffness (1e9 1/s); deduced from the stage's own equation it does not.
        check(CULM_ARKODE(SetDeduceImplicitRhs)(ark, SUNTRUE), "SetDeduceImplicitRhs");
    }

    void restart(N_Vector state, const StepBounds& bounds) override {
        void* const ark = memory_.get();
        check(ARKStepReInit(ark, nullptr, evaluate_rate, 0.0, state), "ReInit");
        check(CULM_ARKODE(SetInitStep)(ark, bounds.first), "SetInitStep");
        check(CULM_ARKODE(SetMaxStep)(ark, std::isfinite(bounds.longest) ? bounds.longest : 0.0),
              "SetMaxStep");
    }

    StepEnd step(double until, N_Vector state) override {
        StepEnd end;
        end.flag = CULM_ARKODE(Evolve)(memory_.get(), until, state, &end.time, ARK_ONE_STEP);
        return end;
    }

    void add_counts(SolveSummary& work) const override {
        long int steps = 0;
        long int error_failures = 0;
        long int convergence_failures = 0;
        CULM_ARKODE(GetNumSteps)(memory_.get(), &steps);
        CULM_ARKODE(GetNumErrTestFails)(memory_.get(), &error_failures);
        CULM_ARKODE(GetNumStepSolveFails)(memory_.get(), &convergence_failures);
        work.steps += steps;
        work.rejected_steps += error_failures;
        work.convergence_failures += convergence_failures;
    }

    [[nodiscard]] std::string flag_name(int flag) const override {
        char* const name = CULM_ARKODE(GetReturnFlagName)(flag);
        std::string text(name);
        std::free(name);
        return text;
    }

  private:
    StepControl control_; // outlives the memory that refers to it
    std::unique_ptr<void, ArkodeDeleter> memory_;
};

} // namespace

std::unique_ptr<Stepper> make_arkode(const StepperParts& parts, const std::string& table) {
    return std::make_unique<Arkode>(parts, table);
}

} // namespace culm::integrate::sundials
