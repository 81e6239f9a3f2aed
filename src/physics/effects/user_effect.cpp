// SPDX-License-Identifier: BSD-3-Clause
#include "physics/effects/user_effect.hpp"

#include "core/error.hpp"
#include "physics/effects/library.hpp"
#include "physics/effects/user_expression.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include <fmt/format.h>

namespace culm::physics {

namespace {

struct NamedKind {
    const char* name;
    UserLawKind kind;
    const char* law;
};
constexpr std::array<NamedKind, 3> kinds{{
    {"force_per_length", UserLawKind::ForcePerLength, "sideways force per length, N/m"},
    {"bending_moment", UserLawKind::BendingMoment, "moment added to E I κ, N m"},
    {"base_moment", UserLawKind::BaseMoment, "moment on the stem at the clamp, which turns, N m"},
}};

/// At rest, and at motions of a stem's size in both directions.
std::vector<UserLawInputs> samples() {
    std::vector<UserLawInputs> inputs;
    for (const double side : {0.0, 1.0, -1.0})
        for (const double turn : {1.0, -1.0})
            for (const double place : {0.0, 1.0})
                inputs.push_back({.position = 0.1 * place,
                                  .deflection = 0.01 * side,
                                  .velocity = 1.0 * side * turn,
                                  .curvature = 2.0 * side,
                                  .curvature_rate = 100.0 * side * turn,
                                  .time = 0.05 * place});
    return inputs;
}

/// All defaults, then each parameter at its bounds.
std::vector<std::vector<double>> parameter_samples(const std::vector<EffectParameter>& parameters) {
    std::vector<double> defaults;
    defaults.reserve(parameters.size());
    for (const EffectParameter& parameter : parameters)
        defaults.push_back(parameter.default_value);
    std::vector<std::vector<double>> sets{defaults};
    for (std::size_t k = 0; k < parameters.size(); ++k)
        for (const double bound : {parameters[k].lower, parameters[k].upper}) {
            sets.push_back(defaults);
            sets.back()[k] = bound;
        }
    return sets;
}

bool is_plain_name(std::string_view name, bool capitals) {
    const auto is_letter = [&](char c) {
        return (c >= 'a' && c <= 'z') || c == '_' || (capitals && c >= 'A' && c <= 'Z');
    };
    return !name.empty() && name.size() <= 60 && is_letter(name.front()) &&
           std::ranges::all_of(name,
                               [&](char c) { return is_letter(c) || (c >= '0' && c <= '9'); });
}

} // namespace

std::vector<std::string> user_law_kind_names() {
    std::vector<std::string> names;
    names.reserve(kinds.size());
    for (const NamedKind& kind : kinds)
        names.emplace_back(kind.name);
    return names;
}

std::optional<UserLawKind> user_law_kind(std::string_view name) {
    const auto* found = std::ranges::find(kinds, name, &NamedKind::name);
    return found == kinds.end() ? std::nullopt : std::optional(found->kind);
}

std::string effect_name_fault(std::string_view name) {
    if (!is_plain_name(name, false))
        return "must consist of lower-case letters, digits and underscores";
    const std::vector<std::string> taken = effect_names();
    if (std::ranges::find(taken, name) != taken.end())
        return "is the name of an effect of the library; choose another";
    return "";
}

std::string parameter_name_fault(std::string_view name, UserLawKind kind) {
    if (!is_plain_name(name, true))
        return "must consist of letters, digits and underscores";
    std::vector<std::string> taken = expression_functions();
    for (const std::string& variable : expression_variables(kind))
        taken.push_back(variable);
    taken.emplace_back("pi");
    if (std::ranges::find(taken, name) != taken.end())
        return "means something else in a formula; choose another name";
    return "";
}

EffectPointer make_user_effect(UserEffectText text) {
    ExpressionText formula{text.name, text.kind, text.formula, {}};
    for (const EffectParameter& parameter : text.parameters)
        formula.parameters.push_back(parameter.name);
    auto expression = compile_expression(formula);
    // A parameter that cannot be zero, such as an exponent, is not a size of the effect.
    for (EffectParameter& parameter : text.parameters)
        parameter.is_place = parameter.lower > 0.0 || parameter.upper < 0.0;
    for (const std::vector<double>& parameters : parameter_samples(text.parameters))
        for (const UserLawInputs& inputs : samples())
            try {
                static_cast<void>((*expression)(inputs, parameters));
            } catch (const core::NumericalError& error) {
                throw core::InputError(
                    fmt::format("{}; a formula must have a value at rest and in every motion, for "
                                "all that its parameters' bounds allow",
                                error.what()));
            }
    const auto* kind = std::ranges::find(kinds, text.kind, &NamedKind::kind);
    return make_effect(
        {.name = std::move(text.name),
         .summary = std::move(text.summary),
         .law = fmt::format("{}: {}", kind->law, text.formula),
         .source = std::move(text.source),
         .signature = std::move(text.signature),
         .remedy = std::move(text.remedy),
         .energy = std::move(text.energy),
         .parameters = std::move(text.parameters)},
        [law = text.kind, expression](std::span<const double> values, EffectTarget& target) {
            target.model.user_laws.push_back({law, expression, {values.begin(), values.end()}});
        });
}

} // namespace culm::physics
