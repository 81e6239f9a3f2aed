// SPDX-License-Identifier: BSD-3-Clause
// Implicit integration of a chain by SUNDIALS.
#pragma once

#include "integrate/implicit.hpp"

#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace culm::integrate {

/// Which of SUNDIALS' integrators.
enum class SundialsSolver {
    Arkode, ///< diagonally implicit Runge-Kutta, order 4
    Cvode,  ///< backward differentiation formulas of variable order
};

/// "arkode" or "cvode".
[[nodiscard]] std::string_view to_string(SundialsSolver solver);

/// Version of the SUNDIALS that this program is linked with.
[[nodiscard]] std::string sundials_version();

/// Owns everything that SUNDIALS needs for chains of one layout: context, vectors, matrix, linear
/// solver and integrator. One object serves any number of chains, one after the other, and the
/// result of each does not depend on those before, bit for bit.
template <int Dim>
class SundialsIntegrator {
  public:
    /// `arkode_table`: name of one of ARKODE's Butcher tables in place of the usual one. Throws
    /// core::NumericalError(SolverFailed).
    SundialsIntegrator(const physics::ChainLayout<Dim>& layout, SundialsSolver solver,
                       const std::string& arkode_table = {});
    ~SundialsIntegrator();
    SundialsIntegrator(SundialsIntegrator&&) noexcept;
    SundialsIntegrator& operator=(SundialsIntegrator&&) noexcept;
    SundialsIntegrator(const SundialsIntegrator&) = delete;
    SundialsIntegrator& operator=(const SundialsIntegrator&) = delete;

    /// As integrate_lanes() for one lane, with SUNDIALS' own choice of steps. `options.fixed_step`
    /// and `follow_first_lane` have no meaning here.
    /// Throws Interrupted, and core::NumericalError(UserExpression) of a user's formula.
    [[nodiscard]] LaneOutcome integrate(const physics::Chain<Dim, double>& chain,
                                        const std::vector<double>& released,
                                        const ErrorScales& scales, double duration,
                                        const StepObserver& observe,
                                        const ImplicitOptions& options);

  private:
    class Memory;
    std::unique_ptr<Memory> memory_;
};

} // namespace culm::integrate
