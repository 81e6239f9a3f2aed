// SPDX-License-Identifier: BSD-3-Clause
// The same stem integrated with several explicit steps, sampled at the same times.
#pragma once

#include "run/case_result.hpp"
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

} // namespace culm::run
