// SPDX-License-Identifier: BSD-3-Clause
#include "diagnose/missing_force/force_terms.hpp"

#include "physics/effects/stem_scales.hpp"
#include "physics/effects/user_expression.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/core.h>

namespace culm::diagnose {
namespace {

/// Initial ratio of a coefficient's term to the elastic forces: large enough for a derivative above
/// the noise of the runs, small enough to stay linear.
constexpr double small_share = 1e-3; ///< of the elastic forces
constexpr double widest = 1e4;       ///< bounds of a coefficient, times its scale

bool is_force(physics::UserLawKind kind) {
    return kind == physics::UserLawKind::ForcePerLength;
}

} // namespace

std::vector<std::string> force_terms(physics::UserLawKind kind) {
    if (is_force(kind))
        return {"1", "x", "x*abs(x)", "x^3", "v", "v*abs(v)", "v^3", "x^2*v", "sign(v)*abs(x)"};
    return {"1",
            "kappa*abs(kappa)",
            "kappa^3",
            "kappa_rate*abs(kappa_rate)",
            "kappa^2*kappa_rate",
            "abs(kappa)*kappa_rate"};
}

physics::UserEffectText force_text(physics::UserLawKind kind, const std::vector<std::string>& terms,
                                   const std::vector<double>& values,
                                   const std::vector<double>& scales) {
    physics::UserEffectText text;
    text.name = "missing_force";
    text.summary = "missing force found in a recording";
    text.source = "culm diagnose";
    text.kind = kind;
    for (std::size_t k = 0; k < terms.size(); ++k) {
        const std::string name = fmt::format("c{}", k + 1);
        if (k > 0)
            text.formula += " + ";
        text.formula += fmt::format("{}*{}", name, terms[k]);
        physics::EffectParameter parameter;
        parameter.name = name;
        parameter.unit = is_force(kind) ? "N/m per unit" : "N m per unit";
        parameter.meaning = "coefficient of " + terms[k];
        parameter.default_value = values[k];
        parameter.lower = -widest * scales[k];
        parameter.upper = widest * scales[k];
        parameter.scale = scales[k];
        text.parameters.push_back(std::move(parameter));
    }
    return text;
}

double term_value(physics::UserLawKind kind, const std::string& term,
                  const physics::UserLawInputs& inputs) {
    const auto expression = physics::compile_expression({"missing_force", kind, term, {}});
    return (*expression)(inputs, {});
}

std::vector<double> term_scales(physics::UserLawKind kind, const std::vector<std::string>& terms,
                                const run::CaseSpec& spec) {
    const double length = spec.stem.free_length();
    const double turning = 2.0 * std::numbers::pi * physics::first_frequency(spec.stem);
    physics::UserLawInputs largest;
    largest.position = length;
    largest.deflection = std::max(std::abs(spec.tip_deflection), 1e-6 * length);
    largest.velocity = turning * largest.deflection;
    largest.curvature = 3.0 * largest.deflection / (length * length);
    largest.curvature_rate = turning * largest.curvature;
    const double moment = physics::bending_rigidity(spec.stem) * largest.curvature;
    const double size = small_share * (is_force(kind) ? moment / (length * length) : moment);
    std::vector<double> scales;
    scales.reserve(terms.size());
    for (const std::string& term : terms)
        scales.push_back(size / std::abs(term_value(kind, term, largest)));
    return scales;
}

std::string as_effect_file(const physics::UserEffectText& text) {
    std::string out = fmt::format(
        "# Found by culm diagnose: a force that no effect of the library explains."
        "\n[effect]\nname = \"{}\"\nsummary = \"{}\"\nkind = \"{}\"\n"
        "expression = \"{}\"\nsource = \"{}\"\n",
        text.name, text.summary, is_force(text.kind) ? "force_per_length" : "bending_moment",
        text.formula, text.source);
    for (const physics::EffectParameter& parameter : text.parameters)
        out +=
            fmt::format("\n[parameters.{}]\nmeaning = \"{}\"\nunit = \"{}\"\ndefault = {:e}\n"
                        "lower = {:e}\nupper = {:e}\nscale = {:e}\n",
                        parameter.name, parameter.meaning, parameter.unit, parameter.default_value,
                        parameter.lower, parameter.upper, parameter.scale);
    return out;
}

} // namespace culm::diagnose
