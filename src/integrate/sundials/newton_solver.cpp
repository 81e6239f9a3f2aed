// SPDX-License-Identifier: BSD-3-Clause
#include "integrate/sundials/newton_solver.hpp"

#include "core/error.hpp"
#include "integrate/sundials/compat.hpp"

namespace culm::integrate::sundials {

Context::Context() : context_(create_context()) {
    if (context_ == nullptr)
        throw core::NumericalError(core::FailureKind::SolverFailed, "SUNDIALS gave no context");
}

Context::~Context() {
    SUNContext_Free(&context_);
}

Matrix newton_matrix(const Context& context) {
    SUNMatrix matrix = SUNMatNewEmpty(context.get());
    matrix->ops->getid = [](SUNMatrix) { return SUNMATRIX_CUSTOM; };
    matrix->ops->destroy = [](SUNMatrix m) { SUNMatFreeEmpty(m); };
    // SUNDIALS 6 and 7 differ in the type of this function's result.
    matrix->ops->zero = [](SUNMatrix) -> decltype(matrix->ops->zero(nullptr)) { return 0; };
    return Matrix(matrix);
}

LinearSolver newton_solver(CallbackData& data, const Context& context) {
    SUNLinearSolver solver = SUNLinSolNewEmpty(context.get());
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

} // namespace culm::integrate::sundials
