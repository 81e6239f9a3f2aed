// SPDX-License-Identifier: BSD-3-Clause
// One stem with several explicit steps, side by side in SIMD lanes; the limits of the step.
#pragma once

#include "run/simulate.hpp"

#include <cstdint>
#include <span>
#include <vector>

namespace culm::run {

/// Runs the case (its duration, samples and deflection; not its integrator) explicitly with
/// sample_interval/steps_per_sample for every entry of `steps_per_sample`, so that every step
/// divides the sample interval and all histories share their sample times. Runs go side by side in
/// SIMD lanes. One outcome per entry: `tip_deflection` and `work` are filled, or the failure states
/// the time at which the motion gained energy. Throws Abandoned.
[[nodiscard]] std::vector<CaseOutcome>
simulate_with_steps(const CaseSpec& spec, std::span<const std::int64_t> steps_per_sample,
                    const Heartbeat& heartbeat = {});

struct StabilitySearchOptions {
    double tolerance = 0.01; ///< of the limit: unstable/stable − 1 at the end
    /// Steps after which a motion that has not gained energy counts as stable. A step that exceeds
    /// the limit by the share e makes the fastest mode grow by about 2e a step, from rounding
    /// (1e-16) to the size that is detected: about 20/e steps.
    std::int64_t trial_steps = 20'000;
};

/// Result of the search. Both steps were run with the nonlinear chain.
struct StabilityBracket {
    double stable = 0.0;   ///< s; the largest step that was run without gaining energy
    double unstable = 0.0; ///< s; the smallest step that was run and gained energy
    std::int64_t trials = 0;

    /// Middle of the bracket, s.
    [[nodiscard]] double limit() const { return 0.5 * (stable + unstable); }
};

/// Brackets the limit by runs of the case's stem, released from its deflection: geometric sections
/// of the bracket, eight at once in SIMD lanes, beginning at `start` (s, any guess). The predicted
/// limit is not used. Throws core::NumericalError (StaticFailed, or Instability if no
/// step within a factor of 1e6 around the start is stable or unstable) and Abandoned.
[[nodiscard]] StabilityBracket search_stable_step(const CaseSpec& spec, double start,
                                                  const StabilitySearchOptions& options,
                                                  const Heartbeat& heartbeat = {});

/// Limits of the explicit step, s.
struct TimestepLimits {
    double transverse;     ///< largest stable step of the linearised chain's transverse motion
    double axial;          ///< … of its axial motion
    double published_rule; ///< see published_timestep_rule

    [[nodiscard]] double linearised() const { return transverse < axial ? transverse : axial; }
};

[[nodiscard]] TimestepLimits timestep_limits(const CaseSpec& spec);

/// √(m/k_n), s: the natural unit of the step. Every limit divided by it depends on β, the law and
/// the shape of a bond, not on Y or the density.
[[nodiscard]] double bond_time(const physics::StemParameters<double>& stem);

/// The rule of the paper's authors, 0.95/((1.1 + 2.9β)√(k_n/m)) with a bond's normal stiffness and
/// a sphere's mass, s. It contains a safety factor.
[[nodiscard]] double published_timestep_rule(const physics::StemParameters<double>& stem);

} // namespace culm::run
