// SPDX-License-Identifier: BSD-3-Clause
// One implicit ring-down with a chosen method and tolerance: its history, its fit and its cost.
#pragma once

#include "integrate/solve_summary.hpp"
#include "physics/chain.hpp"

#include <optional>
#include <vector>

namespace culm::bench {

/// A stem of 56 spheres (Table 1 of the paper) that waits for its release.
struct ReleasedStem {
    physics::StemParameters<double> stem;
    std::vector<double> state; ///< the equilibrium, planar

    ReleasedStem(double bond_youngs_modulus, double bond_damping);
};

/// Deflection before the release, m; length of the record and distance of its samples, s.
inline constexpr double tip_deflection = 15e-3;
inline constexpr double record_length = 0.1;
inline constexpr double sample_interval = 5e-5;

struct ProbeOptions {
    std::optional<int> butcher_table{}; ///< ARKODE's number; empty: culm's choice
    double relative_tolerance = 1e-6;
    double cpu_budget = 2.0; ///< s; beyond it the run is given up
    int repeats = 3;         ///< runs above a quarter of the budget are not repeated
};

struct Probe {
    std::vector<double> tip; ///< (samples), m
    integrate::SolveSummary cost;
    double cpu_seconds = 0.0; ///< least of the repeats
    double frequency = 0.0;   ///< b2 of Eq. 1, Hz
    double decay_per_cycle = 0.0;

    [[nodiscard]] double cycles() const { return frequency * record_length; }
};

/// Nothing if the method stalls (budget used up), fails, or yields no vibration that can be fitted.
[[nodiscard]] std::optional<Probe> probe_ring_down(const ReleasedStem& released,
                                                   const ProbeOptions& options);

/// Largest difference of two tip histories, as a share of the released deflection.
[[nodiscard]] double tip_error(const Probe& probe, const Probe& reference);

} // namespace culm::bench
