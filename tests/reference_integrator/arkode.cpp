// SPDX-License-Identifier: BSD-3-Clause
#include "reference_integrator/arkode.hpp"

#include "core/error.hpp"
#include "integrate/condensed_newton.hpp"

#include <cmath>
#include <cstdlib>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>

#include <arkode/arkode_arkstep.h>
#include <fmt/core.h>
#include <nvector/nvector_serial.h>
#include <sundials/sundials_context.h>
#include <sundials/sundials_linearsolver.h>
#include <sundials/sundials_matrix.h>

namespace culm::integrate {
namespace {

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
Vector view_of(double* data, std::size_t size, const Context& context) {
    return Vector(N_VMake_Serial(static_cast<sunindextype>(size), data, context.get()));
}

/// Throws when a set-up call of SUNDIALS reports an error.
void check(int flag, const char* call) {
    if (flag < 0)
        throw core::NumericalError(core::FailureKind::SolverFailed,
                                   fmt::format("{} failed with flag {}", call, flag));
}

/// A SUNMatrix that stands for I − γJ of a chain. It holds no numbers itself: the chain's
/// CondensedNewton does, which the linear-system function of the integrator fills.
template <int Dim>
[[nodiscard]] Matrix newton_matrix(CondensedNewton<Dim>& system, const Context& context) {
    SUNMatrix matrix = SUNMatNewEmpty(context.get());
    matrix->content = &system;
    matrix->ops->getid = [](SUNMatrix) { return SUNMATRIX_CUSTOM; };
    matrix->ops->destroy = [](SUNMatrix m) {
        m->content = nullptr;
        SUNMatFreeEmpty(m);
    };
    matrix->ops->zero = [](SUNMatrix) { return 0; };
    return Matrix(matrix);
}

/// The direct solver for newton_matrix(): the factorisation is made with the matrix, so that only
/// the solve remains.
template <int Dim>
[[nodiscard]] LinearSolver newton_solver(CondensedNewton<Dim>& system, const Context& context) {
    SUNLinearSolver solver = SUNLinSolNewEmpty(context.get());
    solver->content = &system;
    solver->ops->gettype = [](SUNLinearSolver) { return SUNLINEARSOLVER_DIRECT; };
    solver->ops->getid = [](SUNLinearSolver) { return SUNLINEARSOLVER_CUSTOM; };
    solver->ops->initialize = [](SUNLinearSolver) { return 0; };
    solver->ops->setup = [](SUNLinearSolver, SUNMatrix) { return 0; };
    solver->ops->solve = [](SUNLinearSolver s, SUNMatrix, N_Vector x, N_Vector b, realtype) {
        static_cast<CondensedNewton<Dim>*>(s->content)
            ->solve(N_VGetArrayPointer(b), N_VGetArrayPointer(x));
        return 0;
    };
    solver->ops->free = [](SUNLinearSolver s) {
        s->content = nullptr;
        SUNLinSolFreeEmpty(s);
        return 0;
    };
    return LinearSolver(solver);
}

/// L-stable, stiffly accurate, order 4 with an embedded order 3, six stages: Kennedy & Carpenter
/// (2003), ARK4(3)6L[2]SA, the implicit half. docs/performance.md compares 19 tables.
constexpr ARKODE_DIRKTableID method = ARKODE_ARK436L2SA_DIRK_6_3_4;
/// ARKODE's number of the predictor that extrapolates the last step's interpolant at full order.
/// Without it the simplified Newton iteration, and not accuracy, limits the step.
constexpr int full_order_predictor = 1;

/// What SUNDIALS hands back to its callbacks.
template <int Dim>
struct Callbacks {
    const physics::Chain<Dim, double>& chain;
    CondensedNewton<Dim>& newton;
    std::int64_t jacobian_evaluations = 0;
    std::int64_t factorisations = 0;

    static int evaluate_rate(realtype, N_Vector state, N_Vector rate, void* user) {
        auto& self = *static_cast<Callbacks*>(user);
        self.chain.evaluate_rate(N_VGetArrayPointer(state), N_VGetArrayPointer(rate));
        return 0;
    }

    static int set_up_newton(realtype, N_Vector state, N_Vector, SUNMatrix, SUNMatrix,
                             booleantype jacobian_is_usable, booleantype* jacobian_is_new,
                             realtype gamma, void* user, N_Vector, N_Vector, N_Vector) {
        auto& self = *static_cast<Callbacks*>(user);
        if (!jacobian_is_usable) {
            self.newton.set_state(N_VGetArrayPointer(state));
            ++self.jacobian_evaluations;
        }
        *jacobian_is_new = !jacobian_is_usable;
        ++self.factorisations;
        return self.newton.factorise(gamma) ? 0 : 1;
    }
};

template <int Dim>
std::vector<double> absolute_tolerances(const physics::ChainLayout<Dim>& layout,
                                        const ErrorScales& scales, const ArkodeOptions& options) {
    const double other = options.relative_tolerance / options.bond_error_weight;
    physics::SphereState<Dim, double> sphere;
    sphere.position.component.fill(options.relative_tolerance * scales.displacement);
    sphere.velocity.component.fill(options.relative_tolerance * scales.velocity);
    sphere.spin.component.fill(other * scales.spin);
    physics::BondState<Dim, double> bond;
    bond.shear_force.component.fill(other * scales.shear_force);
    bond.moment.component.fill(other * scales.moment);
    std::vector<double> tolerances(layout.size());
    for (int i = 0; i < layout.sphere_count(); ++i)
        layout.set_sphere(tolerances.data(), i, sphere);
    for (int j = 0; j < layout.bond_count(); ++j)
        layout.set_bond(tolerances.data(), j, bond);
    physics::BondGeometry<Dim, double> geometry;
    geometry.length = options.relative_tolerance * scales.displacement;
    // The slope of the released stem is spin over velocity times deflection.
    geometry.direction.component.fill(options.relative_tolerance * scales.displacement *
                                      scales.spin / scales.velocity);
    for (int j = 0; j < layout.bond_count(); ++j)
        layout.set_geometry(tolerances.data(), j, geometry);
    return tolerances;
}

struct ArkodeDeleter {
    void operator()(void* memory) const { ARKStepFree(&memory); }
};
using Arkode = std::unique_ptr<void, ArkodeDeleter>;

/// ARKODE's name of a return flag.
std::string flag_name(int flag) {
    char* const name = ARKStepGetReturnFlagName(flag);
    std::string text(name);
    std::free(name);
    return text;
}

template <int Dim>
SolveSummary summary_of(void* arkode, const Callbacks<Dim>& callbacks) {
    long int steps = 0;
    long int error_failures = 0;
    long int explicit_rhs = 0;
    long int implicit_rhs = 0;
    long int newton = 0;
    ARKStepGetNumSteps(arkode, &steps);
    ARKStepGetNumErrTestFails(arkode, &error_failures);
    ARKStepGetNumRhsEvals(arkode, &explicit_rhs, &implicit_rhs);
    ARKStepGetNumNonlinSolvIters(arkode, &newton);
    return {steps,
            error_failures,
            implicit_rhs,
            newton,
            callbacks.jacobian_evaluations,
            callbacks.factorisations};
}

} // namespace

template <int Dim>
SolveSummary integrate_arkode(const physics::Chain<Dim, double>& chain, std::vector<double>& state,
                              const ErrorScales& scales, double duration,
                              const StepObserver& observe, const ArkodeOptions& options) {
    const Context context;
    chain.layout().set_geometry(state.data());
    CondensedNewton<Dim> newton(chain);
    Callbacks<Dim> callbacks{chain, newton};
    std::vector<double> tolerances = absolute_tolerances(chain.layout(), scales, options);
    const auto y = view_of(state.data(), state.size(), context);
    const auto absolute = view_of(tolerances.data(), tolerances.size(), context);
    const auto matrix = newton_matrix(newton, context);
    const auto solver = newton_solver(newton, context);

    const Arkode arkode(
        ARKStepCreate(nullptr, Callbacks<Dim>::evaluate_rate, 0.0, y.get(), context.get()));
    void* const ark = arkode.get();
    // Failures reach the caller as exceptions; ARKODE's own text on stderr would come from any
    // rank.
    check(ARKStepSetErrHandlerFn(
              ark, [](int, const char*, const char*, char*, void*) {}, nullptr),
          "ARKStepSetErrHandlerFn");
    check(ARKStepSetUserData(ark, &callbacks), "ARKStepSetUserData");
    const auto table = static_cast<ARKODE_DIRKTableID>(options.butcher_table.value_or(method));
    check(ARKStepSetTableNum(ark, table, ARKODE_ERK_NONE), "ARKStepSetTableNum");
    check(ARKStepSVtolerances(ark, 1e-14, absolute.get()), "ARKStepSVtolerances");
    check(ARKStepSetLinearSolver(ark, solver.get(), matrix.get()), "ARKStepSetLinearSolver");
    check(ARKStepSetLinSysFn(ark, Callbacks<Dim>::set_up_newton), "ARKStepSetLinSysFn");
    check(ARKStepSetPredictorMethod(ark, full_order_predictor), "ARKStepSetPredictorMethod");
    // A stage's rate taken from the right-hand side carries the Newton iteration's error times the
    // stiffness (1e9 1/s); deduced from the stage's own equation it does not.
    check(ARKStepSetDeduceImplicitRhs(ark, SUNTRUE), "ARKStepSetDeduceImplicitRhs");

    double time = 0.0;
    observe(time, state);
    for (std::int64_t step = 0; time < duration; ++step) {
        if (step == options.step_limit)
            throw core::NumericalError(
                core::FailureKind::StepLimit,
                fmt::format("the implicit solver used up its {} steps at t = {:.6g} s", step,
                            time));
        const int flag = ARKStepEvolve(ark, duration, y.get(), &time, ARK_ONE_STEP);
        if (flag < 0)
            throw core::NumericalError(core::FailureKind::SolverFailed,
                                       fmt::format("the implicit solver failed at t = {:.6g} s: {}",
                                                   time, flag_name(flag)));
        observe(time, state);
        if (options.heartbeat && !options.heartbeat())
            throw Interrupted{};
    }
    return summary_of(ark, callbacks);
}

template SolveSummary integrate_arkode<2>(const physics::Chain<2, double>&, std::vector<double>&,
                                          const ErrorScales&, double, const StepObserver&,
                                          const ArkodeOptions&);
template SolveSummary integrate_arkode<3>(const physics::Chain<3, double>&, std::vector<double>&,
                                          const ErrorScales&, double, const StepObserver&,
                                          const ArkodeOptions&);

} // namespace culm::integrate
