// SPDX-License-Identifier: BSD-3-Clause
// The condensed Newton system in the shape that SUNDIALS asks for.
#pragma once

#include "integrate/condensed_newton.hpp"
#include "integrate/sundials_handles.hpp"

namespace culm::integrate::sundials {

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

} // namespace culm::integrate::sundials
