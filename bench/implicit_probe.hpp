// SPDX-License-Identifier: BSD-3-Clause
// One implicit ring-down by a chosen method and tolerance: its history, its fit and its cost.
#pragma once

#include "integrate/error_weights.hpp"
#include "integrate/implicit.hpp"
#include "integrate/rosenbrock.hpp"
#include "integrate/solve_summary.hpp"
#include "physics/chain.hpp"

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace culm::bench {

/// Deflection before the release, m; length of the record and distance of its samples, s.
inline constexpr double released_deflection = 15e-3;
inline constexpr double record_length = 0.1;
inline constexpr double sample_interval = 5e-5;

/// A planar stem of 56 spheres (Table 1 of the paper, law schramm2019) about to vibrate.
struct StartedStem {
    physics::StemParameters<double> stem;
    std::vector<double> state;
    double deflection; ///< of the tip, m
};
[[nodiscard]] physics::StemParameters<double> published_stem(double bond_youngs_modulus,
                                                             double bond_damping);
/// A stem in its equilibrium under a force at the tip.
[[nodiscard]] StartedStem released_stem(double bond_youngs_modulus, double bond_damping);

/// The problem that an integrator solves.
struct Problem {
    const physics::Chain<2, double>& chain;
    std::vector<double> state;
    integrate::ErrorScales scales;
    double tolerance;
    integrate::StepObserver observe;
    integrate::Heartbeat heartbeat;
};
using Method = std::function<integrate::SolveSummary(Problem&)>;

/// The method that studies use.
[[nodiscard]] Method method_in_use();
/// SUNDIALS' ARKODE with one of its DIRK tables, or with the usual one if the name is empty.
[[nodiscard]] Method arkode_method(const std::string& table = {});
/// A Rosenbrock method: Rodas5, or one of tests/integrate/rosenbrock_methods.hpp.
template <class Coefficients>
[[nodiscard]] Method rosenbrock_method() {
    return [](Problem& problem) {
        integrate::Rosenbrock<2, double, Coefficients> rosenbrock(
            problem.chain, problem.state, problem.scales, problem.tolerance, 0.0);
        const integrate::StepController& controller = rosenbrock.controller(0);
        problem.observe(0.0, rosenbrock.state());
        while (controller.time() < record_length) {
            if (rosenbrock.try_step({true})[0])
                problem.observe(controller.time(), rosenbrock.state());
            if (controller.has_failed() || !problem.heartbeat())
                throw integrate::Interrupted{};
        }
        integrate::SolveSummary work;
        work.steps = controller.accepted_steps();
        work.rejected_steps = controller.rejected_steps();
        return work;
    };
}

struct ProbeOptions {
    double tolerance = integrate::ImplicitOptions{}.relative_tolerance;
    double cpu_budget = 2.0; ///< s; a longer run is stopped
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

/// Empty if the method stalls (budget used up), fails, or yields no vibration that can be fitted.
[[nodiscard]] std::optional<Probe> probe_ring_down(const StartedStem& start, const Method& method,
                                                   const ProbeOptions& options);

/// Largest difference of two tip histories, as a share of the released deflection.
[[nodiscard]] double tip_error(const Probe& probe, const Probe& reference);

} // namespace culm::bench
