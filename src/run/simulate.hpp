// SPDX-License-Identifier: BSD-3-Clause
// CaseSpec -> CaseResult: no files, no MPI, no globals.
#pragma once

#include "run/case_spec.hpp"

#include <span>
#include <vector>

namespace culm::run {

/// Called every millisecond or so of work; returning false abandons the work.
using integrate::Heartbeat;

/// Thrown out of simulate() when the heartbeat returned false.
using Abandoned = integrate::Interrupted;

/// Simulates cases, and keeps the integrators of SUNDIALS from one to the next. No result depends
/// on the cases before it, bit for bit.
class Simulator {
  public:
    /// Pulls the tip aside, finds the static equilibrium, releases it and follows the free
    /// vibration. A case that cannot be computed returns a CaseFailure.
    [[nodiscard]] CaseOutcome simulate(const CaseSpec& spec, const Heartbeat& heartbeat = {});

    /// The same for several cases, those that can share SIMD lanes side by side (see
    /// can_share_lanes). One outcome per case, in order. A case's result does not depend on its
    /// neighbours, bit for bit; it agrees with simulate()'s to rounding.
    [[nodiscard]] std::vector<CaseOutcome> simulate_together(std::span<const CaseSpec> specs,
                                                             const Heartbeat& heartbeat = {});

  private:
    [[nodiscard]] std::vector<CaseOutcome> simulate_lanes(std::span<const CaseSpec> batch,
                                                          const Heartbeat& heartbeat);

    integrate::SundialsIntegrators integrators_;
};

/// Simulates one case with a new Simulator.
[[nodiscard]] CaseOutcome simulate(const CaseSpec& spec, const Heartbeat& heartbeat = {});

/// Whether two cases may run in neighbouring lanes: equal numbers of spheres and dimensions, law
/// and method, which is not SUNDIALS; implicit ones with equal tolerance and step limit, explicit
/// ones with equal step, duration and samples.
[[nodiscard]] bool can_share_lanes(const CaseSpec& a, const CaseSpec& b);

/// Number of cases that fill the lanes of this machine.
[[nodiscard]] std::size_t lanes_per_batch();
/// Number of lanes of a case's method; 1 for SUNDIALS.
[[nodiscard]] std::size_t lanes_per_batch(IntegrationMethod method);

/// The largest stable explicit step of a case, s: velocity Verlet on the linearised straight chain,
/// transverse and axial motion. Beyond it the motion grows without bound.
[[nodiscard]] double largest_stable_timestep(const CaseSpec& spec);

} // namespace culm::run
