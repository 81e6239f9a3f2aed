// SPDX-License-Identifier: BSD-3-Clause
#include "diagnose/missing_force/missing_force.hpp"

#include "core/error.hpp"
#include "diagnose/missing_force/term_selection.hpp"
#include "diagnose/stem_fit.hpp"
#include "fit/linear/scaled_solve.hpp"
#include "fit/solve/error_solution.hpp"
#include "physics/effects/stem_scales.hpp"
#include "physics/effects/user_effect.hpp"
#include "physics/effects/user_expression.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace culm::diagnose {
namespace {

using physics::UserLawKind;

constexpr std::size_t most_terms = 3;
constexpr double force_block_periods = 3.0;
constexpr int curve_points = 41;
/// Initial ratio of a coefficient's term to the elastic forces: large enough for a derivative above
/// the noise of the runs, small enough to stay linear.
constexpr double small_share = 1e-3; ///< of the elastic forces
constexpr double widest = 1e4;       ///< bounds of a coefficient, times its scale

bool is_force(UserLawKind kind) {
    return kind == UserLawKind::ForcePerLength;
}

const char* name_of(UserLawKind kind) {
    return is_force(kind) ? "force_per_length" : "bending_moment";
}

/// Powers and products of the variables of a user's law, without the terms that the chain already
/// contains (a moment in proportion to the curvature and to its rate).
std::vector<std::string> force_terms(UserLawKind kind) {
    if (is_force(kind))
        return {"1", "x", "x*abs(x)", "x^3", "v", "v*abs(v)", "v^3", "x^2*v", "sign(v)*abs(x)"};
    return {"1",
            "kappa*abs(kappa)",
            "kappa^3",
            "kappa_rate*abs(kappa_rate)",
            "kappa^2*kappa_rate",
            "abs(kappa)*kappa_rate"};
}

/// Coefficient of term k in the effect that represents the missing force.
physics::ParameterId coefficient(std::size_t k) {
    return {"missing_force", fmt::format("c{}", k + 1), {}};
}

/// The sum of the terms, each with its own coefficient (c1, c2, …), as a user's effect with the
/// name "missing_force"; `values` are the defaults, `scales` their typical sizes.
physics::UserEffectText force_text(UserLawKind kind, const std::vector<std::string>& terms,
                                   const std::vector<double>& values,
                                   const std::vector<double>& scales) {
    physics::UserEffectText text;
    text.name = "missing_force";
    text.summary = "missing force found in a recording";
    text.source = "culm diagnose";
    text.kind = kind;
    std::vector<std::string> products;
    for (std::size_t k = 0; k < terms.size(); ++k) {
        physics::EffectParameter parameter;
        parameter.name = coefficient(k).name;
        products.push_back(parameter.name + "*" + terms[k]);
        parameter.unit = is_force(kind) ? "N/m per unit" : "N m per unit";
        parameter.meaning = "coefficient of " + terms[k];
        parameter.default_value = values[k];
        parameter.lower = -widest * scales[k];
        parameter.upper = widest * scales[k];
        parameter.scale = scales[k];
        text.parameters.push_back(std::move(parameter));
    }
    text.formula = fmt::format("{}", fmt::join(products, " + "));
    return text;
}

/// The value of a term at a point of the stem.
double term_value(UserLawKind kind, const std::string& term, const physics::UserLawInputs& inputs) {
    const auto expression = physics::compile_expression({"missing_force", kind, term, {}});
    return (*expression)(inputs, {});
}

/// Coefficients for which each term, at the largest motion of a stem, is about a thousandth of the
/// elastic forces.
std::vector<double> term_scales(UserLawKind kind, const std::vector<std::string>& terms,
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

/// TOML file of a user's effect.
std::string as_effect_file(const physics::UserEffectText& text) {
    std::string out =
        fmt::format("# Found by culm diagnose: a force that no effect of the library explains."
                    "\n[effect]\nname = \"{}\"\nsummary = \"{}\"\nkind = \"{}\"\n"
                    "expression = \"{}\"\nsource = \"{}\"\n",
                    text.name, text.summary, name_of(text.kind), text.formula, text.source);
    for (const physics::EffectParameter& parameter : text.parameters)
        out +=
            fmt::format("\n[parameters.{}]\nmeaning = \"{}\"\nunit = \"{}\"\ndefault = {:e}\n"
                        "lower = {:e}\nupper = {:e}\nscale = {:e}\n",
                        parameter.name, parameter.meaning, parameter.unit, parameter.default_value,
                        parameter.lower, parameter.upper, parameter.scale);
    return out;
}

/// Index of the time block of every reading; blocks of different recordings differ.
std::vector<int> blocks_of(const fit::Fit& base) {
    std::vector<int> blocks;
    int first = 0;
    for (const fit::RecordingFit& part : base.parts) {
        const double length = force_block_periods / physics::first_frequency(part.model.spec.stem);
        int last = first;
        for (const double time : part.times) {
            last = first + static_cast<int>((time - part.times.front()) / length);
            blocks.insert(blocks.end(), part.prediction.rows, last);
        }
        first = last + 1;
    }
    return blocks;
}

physics::SelectedEffect with_terms(UserLawKind kind, const std::vector<std::string>& terms,
                                   const std::vector<double>& values,
                                   const std::vector<double>& scales) {
    return {physics::make_user_effect(force_text(kind, terms, values, scales)),
            std::vector<std::optional<double>>(terms.size())};
}

/// Linear regression of the residual on the terms of one kind.
struct Regression {
    UserLawKind kind = UserLawKind::ForcePerLength;
    std::vector<std::string> terms; ///< chosen
    std::vector<double> scales;
    std::vector<double> values;
    SelectedTerms selected;
};

Regression regress(UserLawKind kind, const fit::Fit& base,
                   std::span<const fit::ObservedRecording> recordings,
                   const fit::FitOptions& options) {
    const std::vector<std::string> terms = force_terms(kind);
    const std::vector<double> scales = term_scales(kind, terms, base.parts.front().model.spec);
    const physics::SelectedEffect trial =
        with_terms(kind, terms, std::vector<double>(terms.size(), 0.0), scales);
    std::vector<fit::StemModel> models;
    for (std::size_t m = 0; m < recordings.size(); ++m)
        models.push_back(candidate_model(base.parts[m].model, {trial}, recordings[m]));
    const fit::WeightedSystem larger = fit::system_at(models, base, recordings, options.heartbeat);
    const fit::WeightedSystem& fitted = base.system;

    // Both sides without the part that the fitted parameters can absorb (Frisch, Waugh and Lovell):
    // the coefficients are those of a regression in which these parameters are free as well.
    const fit::Projector own(fitted.jacobian);
    Eigen::MatrixXd columns(fitted.readings(), static_cast<Eigen::Index>(terms.size()));
    for (std::size_t k = 0; k < terms.size(); ++k) {
        const auto found = std::ranges::find(larger.ids, coefficient(k));
        // In units of the scale, so that the sums of products have similar magnitudes.
        columns.col(static_cast<Eigen::Index>(k)) =
            scales[k] * own.remainder(larger.jacobian.col(found - larger.ids.begin()))
                            .topRows(fitted.readings());
    }
    const Eigen::VectorXd residual = own.remainder(fitted.residual).topRows(fitted.readings());
    Regression out;
    out.kind = kind;
    out.selected = select_terms(columns, residual, blocks_of(base), most_terms);
    for (std::size_t k = 0; k < out.selected.columns.size(); ++k) {
        const std::size_t column = out.selected.columns[k];
        out.terms.push_back(terms[column]);
        out.scales.push_back(scales[column]);
        out.values.push_back(scales[column] *
                             out.selected.coefficients(static_cast<Eigen::Index>(k)));
    }
    return out;
}

double force_of(const MissingForce& force, UserLawKind kind, const physics::UserLawInputs& inputs) {
    double sum = 0.0;
    for (const ForceTerm& term : force.terms)
        sum += term.coefficient * term_value(kind, term.term, inputs);
    return sum;
}

/// Samples the force at the tip against the deflection at rest and the velocity at zero deflection
/// (for a moment, against the curvature and its rate at the root).
void add_curves(UserLawKind kind, const run::CaseSpec& spec, MissingForce& force) {
    const double length = spec.stem.free_length();
    const double pull = std::abs(spec.tip_deflection);
    const double turning = 2.0 * std::numbers::pi * physics::first_frequency(spec.stem);
    const double curvature = 3.0 / (length * length); // of the root, per deflection of the tip
    for (int k = 0; k < curve_points; ++k) {
        const double share = 2.0 * k / (curve_points - 1.0) - 1.0;
        physics::UserLawInputs at_rest;
        at_rest.position = is_force(kind) ? length : 0.0;
        physics::UserLawInputs undeflected = at_rest;
        at_rest.deflection = share * pull;
        at_rest.curvature = curvature * at_rest.deflection;
        undeflected.velocity = share * turning * pull;
        undeflected.curvature_rate = curvature * undeflected.velocity;
        force.against_displacement.push_back(
            {at_rest.deflection, 0.0, force_of(force, kind, at_rest)});
        force.against_velocity.push_back(
            {0.0, undeflected.velocity, force_of(force, kind, undeflected)});
    }
}

/// The work over a cycle of x = sin t, v = cos t shows which terms add or remove energy.
std::string character_of(const MissingForce& force, UserLawKind kind, const run::CaseSpec& spec) {
    const double length = spec.stem.free_length();
    const double pull = std::abs(spec.tip_deflection);
    const double turning = 2.0 * std::numbers::pi * physics::first_frequency(spec.stem);
    double in_phase = 0.0;
    double with_velocity = 0.0;
    double squares = 0.0;
    double mean = 0.0;
    constexpr int steps = 200;
    for (int k = 0; k < steps; ++k) {
        // First Fourier coefficients of the force over the cycle, by the midpoint rule, which is
        // exact for polynomials in sine and cosine up to the number of steps.
        const double angle = 2.0 * std::numbers::pi * (k + 0.5) / steps;
        physics::UserLawInputs inputs;
        inputs.position = is_force(kind) ? length : 0.0;
        inputs.deflection = pull * std::sin(angle);
        inputs.velocity = turning * pull * std::cos(angle);
        inputs.curvature = 3.0 * inputs.deflection / (length * length);
        inputs.curvature_rate = 3.0 * inputs.velocity / (length * length);
        const double value = force_of(force, kind, inputs);
        in_phase += value * std::sin(angle) * 2.0 / steps;
        with_velocity += value * std::cos(angle) * 2.0 / steps;
        mean += value / steps;
        squares += value * value / steps;
    }
    // A force on the stem takes energy against the velocity; an elastic moment counts as
    // resistance.
    const double sign = is_force(kind) ? -1.0 : 1.0;
    const double dissipated = sign * with_velocity;
    const double restoring = sign * in_phase;
    const double size = std::sqrt(squares);
    std::vector<std::string> parts;
    if (dissipated > 0.3 * size)
        parts.emplace_back("dissipative");
    if (dissipated < -0.3 * size)
        parts.emplace_back("feeds energy in (or the bonds' damping was overestimated)");
    if (restoring > 0.3 * size)
        parts.emplace_back("stiffens");
    if (restoring < -0.3 * size)
        parts.emplace_back("softens");
    if (std::abs(mean) > 0.3 * size)
        parts.emplace_back("one-sided");
    return parts.empty() ? "neither clearly dissipative nor conservative"
                         : fmt::format("{}", fmt::join(parts, ", "));
}

} // namespace

MissingForce reconstruct_missing_force(const fit::Fit& base, const fit::SelectedEffects& effects,
                                       std::span<const fit::ObservedRecording> recordings,
                                       const fit::FitOptions& options) {
    MissingForce out;
    std::optional<Regression> best;
    for (const UserLawKind kind : {UserLawKind::ForcePerLength, UserLawKind::BendingMoment}) {
        try {
            Regression regression = regress(kind, base, recordings, options);
            if (!regression.terms.empty() &&
                (!best || regression.selected.validation < best->selected.validation))
                best = std::move(regression);
        } catch (const core::NumericalError&) { // this kind of force cannot be computed here
        }
    }
    if (!best)
        return out;
    out.kind = name_of(best->kind);
    fit::SelectedEffects larger = effects;
    larger.push_back(with_terms(best->kind, best->terms, best->values, best->scales));
    const fit::Fit fit = fit_larger(larger, base, recordings, options);
    out.fit = fit::to_numbers(fit);
    std::vector<std::string> products;
    for (std::size_t k = 0; k < best->terms.size(); ++k) {
        ForceTerm term{best->terms[k], best->values[k], 0.0, best->selected.stability[k]};
        for (const fit::FittedParameter& parameter : fit.parameters)
            if (parameter.id == coefficient(k)) {
                term.coefficient = parameter.value;
                term.standard_error = parameter.standard_error;
            }
        products.push_back(fmt::format("({:.4g})*{}", term.coefficient, term.term));
        out.terms.push_back(std::move(term));
    }
    out.form = fmt::format("{}", fmt::join(products, " + "));
    const double excess = base.chi_squared - static_cast<double>(base.readings);
    out.explained = fit.is_fitted() && excess > 0.0
                        ? std::clamp((base.chi_squared - fit.chi_squared) / excess, 0.0, 1.0)
                        : std::max(0.0, 1.0 - best->selected.left);
    const run::CaseSpec& spec = base.parts.front().model.spec;
    out.character = character_of(out, best->kind, spec);
    add_curves(best->kind, spec, out);
    std::vector<double> values;
    for (const ForceTerm& term : out.terms)
        values.push_back(term.coefficient);
    out.as_effect_file = as_effect_file(force_text(best->kind, best->terms, values, best->scales));
    return out;
}

} // namespace culm::diagnose
