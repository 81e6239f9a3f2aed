// SPDX-License-Identifier: BSD-3-Clause
#include "run/sensitivities.hpp"

#include "core/lanes.hpp"
#include "run/case_lanes.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace culm::run {
namespace {

/// Share of a parameter's size by which it is changed. The second derivative of a vibration of N
/// cycles by ln Y is about πN/2 times the first: 3e-5 of error at N = 20; rounding stays at 1e-6.
constexpr double relative_change = 1e-6;

} // namespace

std::vector<CaseParameter> baseline_parameters() {
    return {{physics::bond_youngs_modulus,
             [](const CaseSpec& spec) { return spec.stem.bond_youngs_modulus; },
             [](CaseSpec& spec, double value) { spec.stem.bond_youngs_modulus = value; }},
            {physics::bond_damping, [](const CaseSpec& spec) { return spec.stem.bond_damping; },
             [](CaseSpec& spec, double value) { spec.stem.bond_damping = value; }},
            {physics::tip_deflection, [](const CaseSpec& spec) { return spec.tip_deflection; },
             [](CaseSpec& spec, double value) { spec.tip_deflection = value; }}};
}

SensitivityOutcome simulate_with_sensitivities(const CaseSpec& spec,
                                               std::span<const CaseParameter> parameters,
                                               const Heartbeat& heartbeat) {
    CaseWithSensitivities out;
    constexpr std::size_t parameters_per_batch = core::lane_count - 1;
    static_assert(parameters_per_batch > 0, "the lanes hold the case and at least one neighbour");
    std::size_t first = 0;
    do {
        const std::size_t count = std::min(parameters_per_batch, parameters.size() - first);
        // The unchanged case runs again in every batch, so that differences are taken between lanes
        // with the same steps.
        std::vector<CaseSpec> specs(count + 1, spec);
        std::vector<double> changes;
        for (std::size_t k = 0; k < count; ++k) {
            const CaseParameter& parameter = parameters[first + k];
            const double value = parameter.get(spec);
            const double size = parameter.scale > 0.0 ? parameter.scale : std::abs(value);
            const double changed = value + relative_change * size;
            parameter.set(specs[k + 1], changed);
            changes.push_back(changed - value); // after rounding: it has ten digits
        }
        std::vector<CaseOutcome> outcomes = simulate_on_common_steps(specs, heartbeat);
        for (const CaseOutcome& outcome : outcomes)
            if (const auto* failure = std::get_if<CaseFailure>(&outcome))
                return *failure;
        out.result = std::get<CaseResult>(std::move(outcomes.front()));
        for (std::size_t k = 0; k < count; ++k) {
            auto& changed = std::get<CaseResult>(outcomes[k + 1]).height_deflection;
            std::ranges::transform(changed, out.result.height_deflection, changed.begin(),
                                   [change = changes[k]](double value, double base) {
                                       return (value - base) / change;
                                   });
            out.height_derivatives.push_back(std::move(changed));
        }
        first += count;
    } while (first < parameters.size());
    return out;
}

} // namespace culm::run
