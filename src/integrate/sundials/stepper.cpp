// SPDX-License-Identifier: BSD-3-Clause
#include "integrate/sundials/stepper.hpp"

#include "core/error.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include <fmt/core.h>
#include <nvector/nvector_serial.h>

namespace culm::integrate::sundials {

namespace {

constexpr int shorter_step = 1; ///< SUNDIALS' code of a failure for which a shorter step may help
constexpr int give_up = -1;

bool all_finite(std::span<const double> numbers) {
    double sum = 0.0; // x − x is 0 for every finite x, else NaN
    for (const double number : numbers)
        sum += number - number;
    return sum == 0.0;
}

/// Runs one callback; its exception waits until SUNDIALS has returned.
template <class F>
int guarded(void* callback_data, F&& callback) {
    auto& data = *static_cast<CallbackData*>(callback_data);
    try {
        return callback(data);
    } catch (...) {
        data.exception = std::current_exception();
        return give_up;
    }
}

static_assert(std::is_same_v<Real, double>, "culm needs SUNDIALS with double precision");

double* data(N_Vector vector) {
    return NV_DATA_S(vector);
}

std::size_t size_of(N_Vector vector) {
    return static_cast<std::size_t>(NV_LENGTH_S(vector));
}

std::span<double> values(N_Vector vector) {
    return {data(vector), size_of(vector)};
}

/// z_k = f(x_k, y_k); z may be x or y.
template <class F>
void map(N_Vector x, N_Vector y, N_Vector z, F&& f) {
    const double* const from = data(x);
    const double* const other = data(y);
    double* const to = data(z);
    const std::size_t size = size_of(z);
#pragma GCC ivdep // every number depends only on those with the same index
    for (std::size_t k = 0; k < size; ++k)
        to[k] = f(from[k], other[k]);
}

/// z_k = f(x_k); z may be x.
template <class F>
void map(N_Vector x, N_Vector z, F&& f) {
    map(x, x, z, [&f](double p, double) { return f(p); });
}

/// Σ (x_k w_k)² in eight partial sums, because the order of one sum would forbid SIMD.
double sum_of_squares(N_Vector x, N_Vector w) {
    constexpr std::size_t parts = 8;
    const double* const values = data(x);
    const double* const weights = data(w);
    const std::size_t size = size_of(x);
    double partial[parts] = {};
    std::size_t k = 0;
    for (; k + parts <= size; k += parts)
        for (std::size_t p = 0; p < parts; ++p) {
            const double product = values[k + p] * weights[k + p];
            partial[p] += product * product;
        }
    double sum = 0.0;
    for (; k < size; ++k)
        sum += values[k] * weights[k] * values[k] * weights[k];
    for (const double part : partial)
        sum += part;
    return sum;
}

void linear_sum(Real a, N_Vector x, Real b, N_Vector y, N_Vector z) {
    map(x, y, z, [a, b](double p, double q) { return a * p + b * q; });
}

/// z = Σ c_i X_i; X_0 may be z. One pass, because reading the vectors takes the time.
int linear_combination(int count, Real* c, N_Vector* vectors, N_Vector z) {
    if (count == 1) {
        map(vectors[0], z, [factor = c[0]](double p) { return factor * p; });
        return 0;
    }
    linear_sum(c[0], vectors[0], c[1], vectors[1], z);
    int i = 2;
    for (; i + 1 < count; i += 2) {
        const double* const first = data(vectors[i]);
        const double* const second = data(vectors[i + 1]);
        double* const to = data(z);
        const std::size_t size = size_of(z);
        const double a = c[i];
        const double b = c[i + 1];
#pragma GCC ivdep
        for (std::size_t k = 0; k < size; ++k)
            to[k] += a * first[k] + b * second[k];
    }
    if (i < count)
        linear_sum(1.0, z, c[i], vectors[i], z);
    return 0;
}

/// Callback: the rate of `state`. Positive: try a shorter step; negative: give up.
int evaluate_rate(double time, N_Vector state, N_Vector rate, void* callback_data) {
    return guarded(callback_data, [&](CallbackData& data) {
        ++data.work.rhs_evaluations;
        data.equations->evaluate_rate(time, values(state).data(), values(rate).data());
        return all_finite(values(rate)) ? 0 : shorter_step;
    });
}

/// Callback: I − γJ, with the current Jacobian if it is usable, else with a new one.
int set_up_newton(double time, N_Vector state, Boolean jacobian_is_usable, Boolean* jacobian_is_new,
                  double gamma, void* callback_data) {
    *jacobian_is_new = jacobian_is_usable ? SUNFALSE : SUNTRUE;
    return guarded(callback_data, [&](CallbackData& data) {
        if (!jacobian_is_usable) {
            data.equations->evaluate_jacobian(time, values(state).data());
            ++data.work.jacobian_evaluations;
        }
        ++data.work.factorisations;
        return data.equations->factorise(gamma) ? 0 : shorter_step;
    });
}

/// Callback: the weights of the errors.
int set_weights(N_Vector, N_Vector weights, void* callback_data) {
    const auto& data = *static_cast<const CallbackData*>(callback_data);
    std::ranges::copy(data.equations->weights(), values(weights).begin());
    return 0;
}

/// A vector of `size` zeros. Debian compiles SUNDIALS without optimisation: with the serial
/// vectors' own operations, four fifths of a run pass in sums of arrays. Clones get the operations
/// too.
Vector make_vector(std::size_t size, SUNContext context) {
    Vector vector(N_VNew_Serial(static_cast<sunindextype>(size), context));
    if (!vector)
        return vector;
    const N_Vector_Ops ops = vector->ops;
    ops->nvlinearsum = linear_sum;
    ops->nvconst = [](Real c, N_Vector z) { std::ranges::fill(values(z), c); };
    ops->nvscale = [](Real c, N_Vector x, N_Vector z) {
        map(x, z, [c](double p) { return c * p; });
    };
    ops->nvwrmsnorm = [](N_Vector x, N_Vector w) {
        return std::sqrt(sum_of_squares(x, w) / static_cast<double>(size_of(x)));
    };
    ops->nvlinearcombination = linear_combination;
    N_VConst(0.0, vector.get());
    return vector;
}

/// A SUNMatrix that represents I − γJ of a chain. It contains no numbers: set_up_newton() calls the
/// equations to factorise the matrix.
Matrix newton_matrix(SUNContext context) {
    SUNMatrix matrix = SUNMatNewEmpty(context);
    matrix->ops->getid = [](SUNMatrix) { return SUNMATRIX_CUSTOM; };
    matrix->ops->destroy = [](SUNMatrix m) { SUNMatFreeEmpty(m); };
    // SUNDIALS 6 and 7 differ in the type of this function's result.
    matrix->ops->zero = [](SUNMatrix) -> decltype(matrix->ops->zero(nullptr)) { return 0; };
    return Matrix(matrix);
}

/// The direct solver for newton_matrix(). It only solves, because set_up_newton() has factorised
/// the matrix. `data` must outlive it.
LinearSolver newton_solver(CallbackData& data, SUNContext context) {
    SUNLinearSolver solver = SUNLinSolNewEmpty(context);
    solver->content = &data;
    solver->ops->gettype = [](SUNLinearSolver) { return SUNLINEARSOLVER_DIRECT; };
    solver->ops->getid = [](SUNLinearSolver) { return SUNLINEARSOLVER_CUSTOM; };
    solver->ops->initialize = [](SUNLinearSolver) -> decltype(SUNLinSolInitialize(nullptr)) {
        return 0;
    };
    solver->ops->setup = [](SUNLinearSolver, SUNMatrix) { return 0; };
    solver->ops->solve = [](SUNLinearSolver s, SUNMatrix, N_Vector x, N_Vector b, Real) {
        auto& called = *static_cast<CallbackData*>(s->content);
        ++called.work.linear_solves;
        called.equations->solve(values(b).data(), values(x).data());
        return 0;
    };
    solver->ops->free = [](SUNLinearSolver s) -> decltype(SUNLinSolFree(nullptr)) {
        s->content = nullptr;
        SUNLinSolFreeEmpty(s);
        return 0;
    };
    return LinearSolver(solver);
}

/// L-stable, stiffly accurate, order 4 with an embedded order 3: Kennedy & Carpenter (2016),
/// NASA/TM-2016-219173. docs/performance.md compares the tables.
constexpr const char* default_table = "ARKODE_ESDIRK436L2SA_6_3_4";
/// ARKODE's number of the predictor that extrapolates the last step's interpolant at full order.
/// Without it the simplified Newton iteration, and not accuracy, limits the step.
constexpr int full_order_predictor = 1;
/// Allowed error of Newton's iteration relative to that of the step. With ARKODE's default of 0.1
/// the iteration, and not the method, determines the error of b1.
constexpr double newton_share = 0.01;
void check(int flag, const char* call) {
    if (flag < 0)
        throw core::NumericalError(core::FailureKind::SolverFailed,
                                   fmt::format("{} of SUNDIALS failed with flag {}", call, flag));
}

/// Callback: set_up_newton() with ARKODE's arguments.
int set_up_arkode_newton(Real time, N_Vector state, N_Vector, SUNMatrix, SUNMatrix,
                         Boolean is_usable, Boolean* is_new, Real gamma, void* data, N_Vector,
                         N_Vector, N_Vector) {
    return set_up_newton(time, state, is_usable, is_new, gamma, data);
}

} // namespace

Stepper::Stepper(std::size_t size, const std::string& table)
    : state_(make_vector(size, context_.get())), matrix_(newton_matrix(context_.get())),
      linear_solver_(newton_solver(data_, context_.get())), control_(context_.get()),
      memory_(ARKStepCreate(nullptr, evaluate_rate, 0.0, state_.get(), context_.get())) {
    void* const ark = memory_.get();
    if (ark == nullptr)
        throw core::NumericalError(core::FailureKind::SolverFailed,
                                   "SUNDIALS gave no memory for an integrator");
    check(silence_arkode(ark), "SetErrHandlerFn");
    check(CULM_ARKODE(SetUserData)(ark, &data_), "SetUserData");
    check(CULM_ARKODE(WFtolerances)(ark, set_weights), "WFtolerances");
    check(CULM_ARKODE(SetLinearSolver)(ark, linear_solver_.get(), matrix_.get()),
          "SetLinearSolver");
    check(CULM_ARKODE(SetLinSysFn)(ark, set_up_arkode_newton), "SetLinSysFn");
    const std::string& name = table.empty() ? default_table : table;
    check(ARKStepSetTableName(ark, name.c_str(), "ARKODE_ERK_NONE"), "SetTableName");
    check(CULM_ARKODE(SetPredictorMethod)(ark, full_order_predictor), "SetPredictorMethod");
    check(CULM_ARKODE(SetNonlinConvCoef)(ark, newton_share), "SetNonlinConvCoef");
    // A stage's rate taken from the right-hand side carries the Newton iteration's error times the
    // stiffness (1e9 1/s); deduced from the stage's own equation it does not.
    check(CULM_ARKODE(SetDeduceImplicitRhs)(ark, SUNTRUE), "SetDeduceImplicitRhs");
    check(control_.attach_to(ark), "SetAdaptController");
}

std::span<double> Stepper::state() const {
    return values(state_.get());
}

void Stepper::restart(Equations& equations, double first, double longest) {
    data_ = {&equations, {}, nullptr};
    void* const memory = memory_.get();
    check(ARKStepReInit(memory, nullptr, evaluate_rate, 0.0, state_.get()), "ReInit");
    check(CULM_ARKODE(SetInitStep)(memory, first), "SetInitStep");
    const double bound = std::isfinite(longest) ? longest : 0.0; // 0: unbounded
    check(CULM_ARKODE(SetMaxStep)(memory, bound), "SetMaxStep");
}

int Stepper::step(double until, double& time) {
    const int flag = CULM_ARKODE(Evolve)(memory_.get(), until, state_.get(), &time, ARK_ONE_STEP);
    if (data_.exception)
        std::rethrow_exception(data_.exception);
    return flag;
}

SolveSummary Stepper::work() const {
    const auto count = [this](int (*function)(void*, long int*)) {
        long int number = 0;
        function(memory_.get(), &number);
        return std::int64_t{number};
    };
    SolveSummary work = data_.work;
    work.steps += count(CULM_ARKODE(GetNumSteps));
    work.rejected_steps += count(CULM_ARKODE(GetNumErrTestFails));
    work.convergence_failures += count(CULM_ARKODE(GetNumStepSolveFails));
    return work;
}

std::string Stepper::flag_name(int flag) const {
    const std::unique_ptr<char, sundials::Deleter<std::free>> name(
        CULM_ARKODE(GetReturnFlagName)(flag));
    return name.get();
}

} // namespace culm::integrate::sundials
