// SPDX-License-Identifier: BSD-3-Clause
// Releases a deflected stem and prints its tip position and how often it crossed the axis.
#include "run/simulate.hpp"

#include <cstdio>
#include <variant>

int main() {
    culm::run::CaseSpec spec;
    spec.stem.bond_youngs_modulus = 2e9;
    spec.stem.bond_damping = 20.0;
    spec.tip_deflection = 10e-3;
    const culm::run::CaseOutcome outcome = culm::run::simulate(spec);
    const auto* const result = std::get_if<culm::run::CaseResult>(&outcome);
    if (result == nullptr)
        return 1;
    int crossings = 0;
    for (std::size_t k = 1; k < result->tip_deflection.size(); ++k)
        crossings += (result->tip_deflection[k - 1] > 0.0) != (result->tip_deflection[k] > 0.0);
    std::printf("%.3f %d\n", 1e3 * result->tip_deflection.front(), crossings);
    return 0;
}
