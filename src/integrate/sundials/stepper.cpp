// SPDX-License-Identifier: BSD-3-Clause
#include "integrate/sundials/stepper.hpp"

#include "core/error.hpp"

#include <cmath>
#include <cstdlib>

#include <fmt/core.h>

namespace culm::integrate::sundials {

struct SteppingFunctions {
    void (*free)(void**);
    int (*restart)(void*, N_Vector);
    int (*silence)(void*);
    int (*set_user_data)(void*, void*);
    int (*set_weight_function)(void*, int (*)(N_Vector, N_Vector, void*));
    int (*set_linear_solver)(void*, SUNLinearSolver, SUNMatrix);
    int (*set_first_step)(void*, Real);
    int (*set_longest_step)(void*, Real);
    int (*evolve)(void*, Real, N_Vector, Real*, int);
    int (*count_steps)(void*, long int*);
    int (*count_error_test_failures)(void*, long int*);
    int (*count_convergence_failures)(void*, long int*);
    char* (*flag_name)(long int);
};

namespace {

constexpr SteppingFunctions arkode_functions{CULM_ARKODE(Free),
                                             [](void* ark, N_Vector state) {
                                                 return ARKStepReInit(ark, nullptr, evaluate_rate,
                                                                      0.0, state);
                                             },
                                             silence_arkode,
                                             CULM_ARKODE(SetUserData),
                                             CULM_ARKODE(WFtolerances),
                                             CULM_ARKODE(SetLinearSolver),
                                             CULM_ARKODE(SetInitStep),
                                             CULM_ARKODE(SetMaxStep),
                                             CULM_ARKODE(Evolve),
                                             CULM_ARKODE(GetNumSteps),
                                             CULM_ARKODE(GetNumErrTestFails),
                                             CULM_ARKODE(GetNumStepSolveFails),
                                             CULM_ARKODE(GetReturnFlagName)};

constexpr SteppingFunctions cvode_functions{
    CVodeFree,
    [](void* cvode, N_Vector state) { return CVodeReInit(cvode, 0.0, state); },
    silence_cvode,
    CVodeSetUserData,
    CVodeWFtolerances,
    CVodeSetLinearSolver,
    CVodeSetInitStep,
    CVodeSetMaxStep,
    CVode,
    CVodeGetNumSteps,
    CVodeGetNumErrTestFails,
    CVodeGetNumStepSolveFails,
    CVodeGetReturnFlagName};

static_assert(static_cast<int>(ARK_ONE_STEP) == static_cast<int>(CV_ONE_STEP));

/// L-stable, stiffly accurate, order 4 with an embedded order 3: Kennedy & Carpenter (2016),
/// NASA/TM-2016-219173. docs/performance.md compares the tables.
constexpr const char* arkode_table = "ARKODE_ESDIRK436L2SA_6_3_4";
/// ARKODE's number of the predictor that extrapolates the last step's interpolant at full order.
/// Without it the simplified Newton iteration, and not accuracy, limits the step.
constexpr int full_order_predictor = 1;
/// Newton's iteration may err by this share of the step's allowed error. With ARKODE's default of
/// 0.1 the iteration, and not the method, determines the error of b1.
constexpr double newton_share = 0.01;
/// BDF of order 3 and more are unstable for vibrations that are hardly damped: with them the high
/// modes of a stem of low damping limit the step to a fraction of their own period.
constexpr int largest_bdf_order = 2;

void check(int flag, const char* call) {
    if (flag < 0)
        throw core::NumericalError(core::FailureKind::SolverFailed,
                                   fmt::format("{} of SUNDIALS failed with flag {}", call, flag));
}

} // namespace

Stepper::Stepper(void* memory, const SteppingFunctions& functions)
    : memory_(memory, {functions.free}), functions_(&functions) {
    if (memory == nullptr)
        throw core::NumericalError(core::FailureKind::SolverFailed,
                                   "SUNDIALS gave no memory for an integrator");
}

void Stepper::set_up(const StepperParts& parts) {
    void* const memory = memory_.get();
    check(functions_->silence(memory), "SetErrHandlerFn");
    check(functions_->set_user_data(memory, &parts.data), "SetUserData");
    check(functions_->set_weight_function(memory, set_weights), "WFtolerances");
    check(functions_->set_linear_solver(memory, parts.solver, parts.matrix), "SetLinearSolver");
}

Stepper Stepper::arkode(const StepperParts& parts, const std::string& table) {
    void* const ark = ARKStepCreate(nullptr, evaluate_rate, 0.0, parts.state, parts.context);
    Stepper stepper(ark, arkode_functions);
    stepper.set_up(parts);
    const auto linear_system = [](Real time, N_Vector state, N_Vector, SUNMatrix, SUNMatrix,
                                  Boolean is_usable, Boolean* is_new, Real gamma, void* data,
                                  N_Vector, N_Vector, N_Vector) {
        *is_new = is_usable ? SUNFALSE : SUNTRUE;
        return set_up_newton(time, state, is_usable != SUNFALSE, gamma, data);
    };
    check(CULM_ARKODE(SetLinSysFn)(ark, linear_system), "SetLinSysFn");
    const std::string& name = table.empty() ? arkode_table : table;
    check(ARKStepSetTableName(ark, name.c_str(), "ARKODE_ERK_NONE"), "SetTableName");
    check(CULM_ARKODE(SetPredictorMethod)(ark, full_order_predictor), "SetPredictorMethod");
    check(CULM_ARKODE(SetNonlinConvCoef)(ark, newton_share), "SetNonlinConvCoef");
    // A stage's rate taken from the right-hand side carries the Newton iteration's error times the
    // stiffness (1e9 1/s); deduced from the stage's own equation it does not.
    check(CULM_ARKODE(SetDeduceImplicitRhs)(ark, SUNTRUE), "SetDeduceImplicitRhs");
    stepper.control_ = std::make_unique<StepControl>(parts.context);
    check(stepper.control_->attach_to(ark), "SetAdaptController");
    return stepper;
}

Stepper Stepper::cvode(const StepperParts& parts) {
    void* const memory = CVodeCreate(CV_BDF, parts.context);
    Stepper stepper(memory, cvode_functions);
    check(CVodeInit(memory, evaluate_rate, 0.0, parts.state), "Init");
    stepper.set_up(parts);
    const auto linear_system = [](Real time, N_Vector state, N_Vector, SUNMatrix, Boolean is_usable,
                                  Boolean* is_new, Real gamma, void* data, N_Vector, N_Vector,
                                  N_Vector) {
        *is_new = is_usable ? SUNFALSE : SUNTRUE;
        return set_up_newton(time, state, is_usable != SUNFALSE, gamma, data);
    };
    check(CVodeSetLinSysFn(memory, linear_system), "SetLinSysFn");
    check(CVodeSetMaxOrd(memory, largest_bdf_order), "SetMaxOrd");
    return stepper;
}

void Stepper::restart(N_Vector state, const StepBounds& bounds) {
    void* const memory = memory_.get();
    check(functions_->restart(memory, state), "ReInit");
    check(functions_->set_first_step(memory, bounds.first), "SetInitStep");
    const double longest = std::isfinite(bounds.longest) ? bounds.longest : 0.0; // 0: unbounded
    check(functions_->set_longest_step(memory, longest), "SetMaxStep");
}

StepEnd Stepper::step(double until, N_Vector state) {
    StepEnd end;
    end.flag = functions_->evolve(memory_.get(), until, state, &end.time, CV_ONE_STEP);
    return end;
}

void Stepper::add_counts(SolveSummary& work) const {
    const auto count = [this](int (*function)(void*, long int*)) {
        long int number = 0;
        function(memory_.get(), &number);
        return std::int64_t{number};
    };
    work.steps += count(functions_->count_steps);
    work.rejected_steps += count(functions_->count_error_test_failures);
    work.convergence_failures += count(functions_->count_convergence_failures);
}

std::string Stepper::flag_name(int flag) const {
    const std::unique_ptr<char, sundials::Deleter<std::free>> name(functions_->flag_name(flag));
    return name.get();
}

} // namespace culm::integrate::sundials
