// SPDX-License-Identifier: BSD-3-Clause
// Fitted parameters and their models, for people and for programs.
#pragma once

#include "core/describe.hpp"
#include "fit/fit.hpp"
#include "reduce/distributions.hpp"

#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace culm::present {

/// "1.90173 ± 0.00065": both to the second significant digit of `half`, half of an interval; five
/// digits of the value if `half` is unknown.
[[nodiscard]] std::string with_uncertainty(double value, double half);

/// `scale` times value and half of the 95 % interval.
[[nodiscard]] std::string plus_minus(const reduce::Estimate& estimate, double scale = 1.0);

/// bond_youngs_modulus_pa, tip_deflection_m, …; effects' parameters have their unit in their name.
/// The key of a parameter of one of several recordings ends in an at sign and the recording's id:
/// `tip_deflection_m@S01`.
[[nodiscard]] std::string parameter_key(const fit::FittedParameter& parameter);

/// The parameters in the order in which they are listed: that of their keys.
[[nodiscard]] std::map<std::string, const fit::FittedParameter*>
by_key(std::span<const fit::FittedParameter> parameters);

/// A fitted parameter of a document.
struct ShownParameter {
    reduce::Estimate estimate;
    std::string unit;
    bool is_at_bound = false;
};
template <class To>
void describe(To& to, const ShownParameter& parameter) {
    describe(to, parameter.estimate);
    to("unit", parameter.unit);
    to("at_bound", parameter.is_at_bound);
}
/// By parameter_key().
[[nodiscard]] std::map<std::string, ShownParameter>
shown_parameters(std::span<const fit::FittedParameter> parameters);

/// Name and unit of a parameter on the screen.
struct ReadableParameter {
    std::string name;        ///< the key without the unit in it: "tip_deflection@T2"
    double scale = 1.0;      ///< from SI units
    std::string_view unit{}; ///< empty: none, or it is in the name (tip_mass.mass_kg)
};

/// Young's modulus in MPa or GPa, depending on its value; deflections in mm, times in ms.
[[nodiscard]] ReadableParameter readable(const fit::FittedParameter& parameter);

/// "1.90173 ± 0.00065 GPa": value and half of its 95 % interval.
[[nodiscard]] std::string value_text(const fit::FittedParameter& parameter);

/// Names the stated inputs and constrained error terms whose pull exceeds fit::contradiction, or
/// states the largest if the model does not describe the readings: then it is wrong, not they.
/// Empty if there are none.
[[nodiscard]] std::string contradiction_sentence(std::span<const fit::Pull> pulls,
                                                 bool describes_readings);

/// A contradicted input.
struct Contradiction {
    std::string name;
    double pull = 0.0;
};
template <class To>
void describe(To& to, const Contradiction& input) {
    to("name", input.name);
    to("pull", input.pull, "in standard uncertainties");
}
[[nodiscard]] std::vector<Contradiction> contradictions_of(std::span<const fit::Pull> pulls);

/// What the chain cannot represent and what the intervals lack, one sentence each.
[[nodiscard]] std::vector<std::string> remarks_on(const fit::RecordingFit& part);

/// "baseline + quadratic_drag".
[[nodiscard]] std::string model_name(const std::vector<std::string>& names);

} // namespace culm::present
