// SPDX-License-Identifier: BSD-3-Clause
// Implicit integration of a chain by ARKODE of SUNDIALS.
#pragma once

#include "integrate/implicit.hpp"

#include <cstddef>
#include <map>
#include <memory>
#include <string>
#include <tuple>
#include <vector>

namespace culm::integrate {

namespace sundials {
class Stepper;
}

/// Version of the SUNDIALS that this program is linked with.
[[nodiscard]] std::string sundials_version();

/// Owns all objects that SUNDIALS needs for chains of one layout: context, vectors, matrix, linear
/// solver and integrator. One object integrates any number of chains, one after the other; each
/// result is bit for bit independent of the preceding ones.
template <int Dim>
class SundialsIntegrator {
  public:
    /// `table`: name of one of ARKODE's Butcher tables instead of the default. Throws
    /// core::NumericalError(SolverFailed).
    explicit SundialsIntegrator(const physics::ChainLayout<Dim>& layout,
                                const std::string& table = {});
    ~SundialsIntegrator();
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
    std::unique_ptr<sundials::Stepper> stepper_;
};

/// One integrator for each layout of a chain, created at its first use.
class SundialsIntegrators {
  public:
    /// Throws core::NumericalError(SolverFailed).
    template <int Dim>
    [[nodiscard]] SundialsIntegrator<Dim>& integrator_for(const physics::ChainLayout<Dim>& layout) {
        return std::get<Kept<Dim>>(kept_).try_emplace(layout.size(), layout).first->second;
    }

  private:
    template <int Dim>
    using Kept = std::map<std::size_t, SundialsIntegrator<Dim>>;

    std::tuple<Kept<2>, Kept<3>> kept_;
};

} // namespace culm::integrate
