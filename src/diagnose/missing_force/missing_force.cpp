// SPDX-License-Identifier: BSD-3-Clause
#include "diagnose/missing_force/missing_force.hpp"

#include "core/error.hpp"
#include "diagnose/models/stem_fit.hpp"
#include "fit/solve/error_solution.hpp"
#include "physics/effects/stem_scales.hpp"
#include "physics/effects/user_effect.hpp"

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
constexpr int curve_points = 41;
/// Initial ratio of a coefficient's term to the elastic forces: large enough for a derivative above
/// the noise of the runs, small enough to stay linear.
constexpr double small_share = 1e-3; ///< of the elastic forces
constexpr double widest = 1e4;       ///< bounds of a coefficient, times its scale
/// Standard deviation of a coefficient before the recording is seen, times its scale.
constexpr double usual = 100.0;
constexpr double term_probability = 0.8; ///< of a term

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

physics::SelectedEffect with_terms(UserLawKind kind, const std::vector<std::string>& terms,
                                   const std::vector<double>& values,
                                   const std::vector<double>& scales) {
    return {physics::make_user_effect(force_text(kind, terms, values, scales)),
            std::vector<std::optional<double>>(terms.size())};
}

/// The terms of one kind that the residual needs.
struct ChosenTerms {
    UserLawKind kind = UserLawKind::ForcePerLength;
    std::vector<std::string> terms;
    std::vector<double> scales;
    std::vector<double> values;
    std::vector<double> probabilities;
};

/// The signature of each term about the base: that of an effect with one size.
EffectView view_of_terms(UserLawKind kind, const std::vector<std::string>& terms,
                         const std::vector<double>& scales, const fit::Fit& base,
                         std::span<const fit::ObservedRecording> recordings,
                         const fit::FitOptions& options) {
    const physics::SelectedEffect trial =
        with_terms(kind, terms, std::vector<double>(terms.size(), 0.0), scales);
    std::vector<fit::StemModel> models;
    for (std::size_t m = 0; m < recordings.size(); ++m)
        models.push_back(candidate_model(base.parts[m].model, {trial}, recordings[m]));
    const fit::WeightedSystem larger = fit::system_at(models, base, recordings, options.heartbeat);
    std::vector<EffectColumns> candidates;
    for (std::size_t k = 0; k < terms.size(); ++k) {
        const auto found = std::ranges::find(larger.ids, coefficient(k));
        Eigen::VectorXd readings = Eigen::VectorXd::Zero(base.system.residual.size());
        readings.head(base.system.readings()) =
            usual * scales[k] *
            larger.jacobian.col(found - larger.ids.begin()).head(base.system.readings());
        EffectColumn column{std::move(readings)};
        column.parameter = 0;
        candidates.push_back({{}, {{{0.0}, 1.0, 1.0, {std::move(column)}}}, 0});
    }
    return view_of(std::move(candidates), shared_columns(base, recordings, {}));
}

/// Chooses among all sets of terms by their log evidence. The residual of the likeliest set counts
/// as noise in all of them, because the true force need not be among them.
ChosenTerms choose_terms(UserLawKind kind, const fit::Fit& base,
                         std::span<const fit::ObservedRecording> recordings,
                         const fit::FitOptions& options) {
    const std::vector<std::string> terms = force_terms(kind);
    const std::vector<double> scales = term_scales(kind, terms, base.parts.front().model.spec);
    const EffectView view = view_of_terms(kind, terms, scales, base, recordings, options);
    double variance = 1.0;
    ChosenTerms out;
    for (int pass = 0; pass < 2; ++pass) {
        const LinearEvidence evidence(view.columns, view.gram / variance, view.overlap / variance);
        std::vector<std::size_t> chosen;
        PredictedGain likeliest;
        std::vector<std::pair<std::vector<std::size_t>, double>> sets{{{}, 0.0}};
        for_each_set(terms.size(), most_terms, [&](const std::vector<std::size_t>& set) {
            PredictedGain gain = evidence.gain(set);
            sets.emplace_back(set, gain.log_evidence);
            if (gain.log_evidence > likeliest.log_evidence) {
                chosen = set;
                likeliest = std::move(gain);
            }
            return true;
        });
        double total = 0.0;
        std::vector<double> held(terms.size(), 0.0);
        for (const auto& [set, log_evidence] : sets) {
            const double weight = std::exp(log_evidence - likeliest.log_evidence);
            total += weight;
            for (const std::size_t k : set)
                held[k] += weight;
        }
        out = {kind, {}, {}, {}, {}};
        double left = base.chi_squared;
        for (std::size_t k = 0; k < chosen.size(); ++k) {
            const PlacedEffect& term = likeliest.points.front().effects[k];
            left -= term.fall;
            if (held[chosen[k]] < term_probability * total)
                continue;
            out.terms.push_back(terms[chosen[k]]);
            out.scales.push_back(scales[chosen[k]]);
            out.values.push_back(usual * scales[chosen[k]] * term.amounts.front());
            out.probabilities.push_back(held[chosen[k]] / total);
        }
        variance =
            std::max(1.0, left / static_cast<double>(std::max<std::size_t>(1, base.readings)));
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
    // Across a large misfit the linear estimates do not decide between the kinds; the fits do.
    std::optional<ChosenTerms> best;
    fit::Fit fit;
    for (const UserLawKind kind : {UserLawKind::ForcePerLength, UserLawKind::BendingMoment}) {
        try {
            ChosenTerms chosen = choose_terms(kind, base, recordings, options);
            if (chosen.terms.empty())
                continue;
            fit::SelectedEffects larger = effects;
            larger.push_back(with_terms(kind, chosen.terms, chosen.values, chosen.scales));
            fit::Fit found = fit_larger(larger, base, recordings, options);
            if (best &&
                (!found.is_fitted() || (fit.is_fitted() && fit.chi_squared <= found.chi_squared)))
                continue;
            best = std::move(chosen);
            fit = std::move(found);
        } catch (const core::NumericalError&) { // this kind of force cannot be computed here
        }
    }
    if (!best)
        return out;
    out.kind = name_of(best->kind);
    out.fit = fit::to_numbers(fit);
    std::vector<std::string> products;
    for (std::size_t k = 0; k < best->terms.size(); ++k) {
        ForceTerm term{best->terms[k], best->values[k], 0.0, best->probabilities[k]};
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
                        : 0.0;
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
