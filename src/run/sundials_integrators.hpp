// SPDX-License-Identifier: BSD-3-Clause
// SUNDIALS' integrators that a process keeps from one case to the next.
#pragma once

#include "integrate/sundials/integrator.hpp"

#include <cstddef>
#include <map>
#include <utility>

namespace culm::run {

/// One integrator for each solver and layout of a chain, made when it is first asked for.
class SundialsIntegrators {
  public:
    /// Throws core::NumericalError(SolverFailed).
    template <int Dim>
    [[nodiscard]] integrate::SundialsIntegrator<Dim>&
    integrator_for(const physics::ChainLayout<Dim>& layout, integrate::SundialsSolver solver) {
        auto& kept = integrators<Dim>();
        const auto key = std::pair(solver, layout.size());
        const auto found = kept.find(key);
        return found != kept.end()
                   ? found->second
                   : kept.emplace(key, integrate::SundialsIntegrator<Dim>(layout, solver))
                         .first->second;
    }

  private:
    template <int Dim>
    using Kept = std::map<std::pair<integrate::SundialsSolver, std::size_t>,
                          integrate::SundialsIntegrator<Dim>>;

    template <int Dim>
    [[nodiscard]] Kept<Dim>& integrators() {
        if constexpr (Dim == 2)
            return planar_;
        else
            return spatial_;
    }

    Kept<2> planar_;
    Kept<3> spatial_;
};

} // namespace culm::run
