// SPDX-License-Identifier: BSD-3-Clause
// The kernels of an implicit step, to be measured one by one.
#pragma once

#include "core/error.hpp"
#include "integrate/condensed_newton.hpp"
#include "integrate/rosenbrock.hpp"
#include "integrate/statics.hpp"

#include <vector>

namespace culm::bench {

/// One number for each kernel of a step, and one for the whole step.
struct Kernels {
    double rate = 0.0;      ///< d(state)/dt
    double jacobian = 0.0;  ///< every bond's, by dual numbers
    double factorise = 0.0; ///< condensation and block-tridiagonal elimination
    double solve = 0.0;     ///< right-hand side, substitution, recovery of condensed variables
    double step = 0.0;

    [[nodiscard]] double stages() const {
        return static_cast<double>(integrate::Rodas5::stages) * (rate + solve);
    }
    [[nodiscard]] double rest() const { return step - stages() - jacobian - factorise; }
};

/// Operations of one stem.
template <int Dim>
[[nodiscard]] Kernels count_kernels();
extern template Kernels count_kernels<2>();
extern template Kernels count_kernels<3>();

inline constexpr double kernel_deflection = 15e-3; ///< of the tip, m

template <class T>
[[nodiscard]] physics::StemParameters<T> kernel_stem() {
    physics::StemParameters<T> stem;
    stem.bond_youngs_modulus = T(1e9);
    stem.bond_damping = T(25.0);
    return stem;
}

/// The equilibrium of the stem, in every lane.
template <int Dim, class T>
[[nodiscard]] std::vector<T> kernel_state() {
    const physics::Chain<Dim, double> chain(kernel_stem<double>(), physics::schramm2019_law());
    const std::vector<double> at_rest =
        integrate::deflected_equilibrium(chain, kernel_deflection).state;
    return {at_rest.begin(), at_rest.end()};
}

/// Applies `measure` to each kernel; 2e-6 s is about γh of a step.
template <int Dim, class T, class Measure>
[[nodiscard]] Kernels each_kernel(const physics::Chain<Dim, T>& chain, const std::vector<T>& state,
                                  Measure&& measure) {
    integrate::CondensedNewton<Dim, T> newton(chain);
    std::vector<T> rate(state.size());
    std::vector<T> solution(state.size());
    Kernels kernels;
    kernels.rate = measure([&] { chain.evaluate_rate(state.data(), rate.data()); });
    kernels.jacobian = measure([&] { newton.set_state(state.data()); });
    bool is_regular = true;
    kernels.factorise = measure([&] { is_regular = newton.factorise(T(2e-6)) && is_regular; });
    if (!is_regular)
        throw core::NumericalError(core::FailureKind::SolverFailed,
                                   "the Newton matrix is singular");
    kernels.solve = measure([&] { newton.solve(rate.data(), solution.data()); });
    return kernels;
}

} // namespace culm::bench
