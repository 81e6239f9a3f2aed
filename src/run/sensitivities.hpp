// SPDX-License-Identifier: BSD-3-Clause
// A case's deflections together with their derivatives by its parameters.
#pragma once

#include "physics/parameter_id.hpp"
#include "run/simulate.hpp"

#include <functional>
#include <span>
#include <variant>
#include <vector>

namespace culm::run {

/// A number of a case that can be varied, in SI units.
struct CaseParameter {
    physics::ParameterId id;
    std::function<double(const CaseSpec&)> get;
    std::function<void(CaseSpec&, double)> set;
    /// The size of a parameter that may be zero; 0: its own value is the size.
    double scale = 0.0;
};

/// Y (Pa), β and the tip's deflection before the release (m).
[[nodiscard]] std::vector<CaseParameter> baseline_parameters();

/// A case and the derivatives of its CaseResult::height_deflection.
struct CaseWithSensitivities {
    CaseResult result;
    /// (parameters)(samples × heights), m per unit
    std::vector<std::vector<double>> height_derivatives;
};
using SensitivityOutcome = std::variant<CaseWithSensitivities, CaseFailure>;

/// Simulates an implicit case and differentiates the camera's readings by every parameter.
///
/// The case and its neighbours, each with one parameter changed by 1e-6 of its size, go through
/// the same steps in SIMD lanes (internal numerical differentiation: Bock 1981). A method without
/// iteration is a smooth function of the parameters, so the difference of two lanes is their
/// derivative to about 1e-5, at the cost of one run of full lanes for every lane_count − 1
/// parameters. The result is bit for bit the same whatever the parameters are, unless the error of
/// a changed lane exceeds the allowed one tenfold: that shortens the steps of all.
[[nodiscard]] SensitivityOutcome
simulate_with_sensitivities(const CaseSpec& spec, std::span<const CaseParameter> parameters,
                            const Heartbeat& heartbeat = {});

} // namespace culm::run
