// SPDX-License-Identifier: BSD-3-Clause
#include "physics/effects/user_effect.hpp"

#include "core/error.hpp"
#include "core/nearest_name.hpp"
#include "physics/effects/library.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <mutex>
#include <numbers>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <muParser.h>

namespace culm::physics {
namespace {

constexpr std::array one_argument{"abs", "sign", "sqrt", "exp",  "ln",   "log10", "sin", "cos",
                                  "tan", "asin", "acos", "atan", "sinh", "cosh",  "tanh"};

double sign(double x) {
    return x > 0.0 ? 1.0 : x < 0.0 ? -1.0 : 0.0;
}
double smallest(const double* values, int count) {
    return *std::min_element(values, values + count);
}
double largest(const double* values, int count) {
    return *std::max_element(values, values + count);
}

/// Defines only these functions, not the parser's own: the meaning of `log`, for example, varies.
void define_functions(mu::Parser& parser) {
    using Function = double (*)(double);
    constexpr std::array<Function, one_argument.size()> functions{
        [](double x) { return std::abs(x); },  sign,
        [](double x) { return std::sqrt(x); }, [](double x) { return std::exp(x); },
        [](double x) { return std::log(x); },  [](double x) { return std::log10(x); },
        [](double x) { return std::sin(x); },  [](double x) { return std::cos(x); },
        [](double x) { return std::tan(x); },  [](double x) { return std::asin(x); },
        [](double x) { return std::acos(x); }, [](double x) { return std::atan(x); },
        [](double x) { return std::sinh(x); }, [](double x) { return std::cosh(x); },
        [](double x) { return std::tanh(x); }};
    parser.ClearFun();
    for (std::size_t k = 0; k < functions.size(); ++k)
        parser.DefineFun(one_argument[k], functions[k]);
    parser.DefineFun("min", smallest);
    parser.DefineFun("max", largest);
    parser.ClearConst();
    parser.DefineConst("pi", std::numbers::pi);
}

/// The message, the formula, and a caret below its column `position`.
[[noreturn]] void refuse(const std::string& formula, std::size_t position,
                         std::string_view message) {
    throw core::InputError(fmt::format("{}\n    {}\n    {}^", message, formula,
                                       std::string(std::min(position, formula.size()), ' ')));
}

/// Mistakes that the parser does not detect or does not explain well.
void check_characters(const std::string& formula) {
    if (formula.find_first_not_of(" \t") == std::string::npos)
        throw core::InputError("the formula is empty");
    if (formula.size() > longest_formula)
        throw core::InputError(fmt::format("the formula has {} characters; {} are allowed",
                                           formula.size(), longest_formula));
    int depth = 0;
    for (std::size_t i = 0; i < formula.size(); ++i) {
        const char c = formula[i];
        const char before = i > 0 ? formula[i - 1] : ' ';
        const char after = i + 1 < formula.size() ? formula[i + 1] : ' ';
        if (static_cast<unsigned char>(c) >= 0x80 || (c < ' ' && c != '\t'))
            refuse(formula.substr(0, i), i,
                   "only plain characters are allowed: write kappa for κ, theta for θ, * for ·, "
                   "- for −; the formula is valid up to here");
        if (c == '"')
            refuse(formula, i, "text is not allowed in a formula");
        if (c == '=' && after != '=' && std::string_view("=!<>").find(before) == std::string::npos)
            refuse(formula, i, "nothing can be assigned here; == compares");
        depth += c == '(' ? 1 : c == ')' ? -1 : 0;
        if (depth > deepest_nesting)
            refuse(formula, i,
                   fmt::format("parentheses are nested deeper than {}", deepest_nesting));
    }
}

std::string unknown_name(const std::string& token, const ExpressionText& text) {
    const std::vector<std::string> variables = expression_variables(text.kind);
    std::vector<std::string> valid = variables;
    valid.insert(valid.end(), text.parameters.begin(), text.parameters.end());
    for (const std::string& function : expression_functions())
        valid.push_back(function);
    valid.emplace_back("pi");
    // A single letter has no similar spelling.
    const std::string nearest = token.size() > 1 ? core::nearest_name(token, valid) : "";
    return fmt::format("unknown name \"{}\"{}; there are {}{}{}, pi, and the functions {}", token,
                       nearest.empty() ? "" : fmt::format(" (did you mean \"{}\"?)", nearest),
                       fmt::join(variables, ", "), text.parameters.empty() ? "" : ", ",
                       fmt::join(text.parameters, ", "), fmt::join(expression_functions(), ", "));
}

[[noreturn]] void refuse(const ExpressionText& text, const mu::ParserError& error) {
    const bool has_place = error.GetPos() >= 0;
    const std::size_t position =
        has_place ? static_cast<std::size_t>(error.GetPos()) : text.formula.size();
    switch (error.GetCode()) {
    case mu::ecUNASSIGNABLE_TOKEN: {
        // The token contains the name and the rest of the formula.
        const std::string& token = error.GetToken();
        const std::string name = token.substr(
            0, token.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ"
                                       "0123456789_"));
        refuse(text.formula, position,
               name.empty() ? fmt::format("unexpected \"{}\"", token.substr(0, 1))
                            : unknown_name(name, text));
    }
    case mu::ecUNEXPECTED_EOF:
        refuse(text.formula, text.formula.size(), "the formula ends too early");
    case mu::ecMISSING_PARENS:
        refuse(text.formula, text.formula.size(), "a closing parenthesis is missing");
    default: {
        const std::string& message = error.GetMsg();
        refuse(text.formula, position, message.substr(0, message.find_last_not_of(". ") + 1));
    }
    }
}

/// The parser with the storage of its variables.
class CompiledExpression {
  public:
    explicit CompiledExpression(ExpressionText text)
        : text_(std::move(text)), variables_(expression_variables(text_.kind)),
          parameters_(text_.parameters.size(), 0.0) {
        check_characters(text_.formula);
        try {
            define_functions(parser_);
            for (std::size_t k = 0; k < variables_.size(); ++k)
                parser_.DefineVar(variables_[k], &inputs_[k]);
            for (std::size_t k = 0; k < parameters_.size(); ++k)
                parser_.DefineVar(text_.parameters[k], &parameters_[k]);
            parser_.SetExpr(text_.formula);
            static_cast<void>(parser_.Eval());
        } catch (const mu::ParserError& error) {
            refuse(text_, error);
        }
        if (parser_.GetNumResults() != 1)
            refuse(text_.formula, text_.formula.find(','),
                   "must be one formula; a decimal number needs a point, not a comma");
    }

    [[nodiscard]] double value(const UserLawInputs& inputs, std::span<const double> parameters) {
        const std::scoped_lock lock(mutex_);
        if (text_.kind == UserLawKind::BaseMoment)
            inputs_ = {inputs.deflection, inputs.velocity, inputs.time};
        else
            inputs_ = {inputs.position,  inputs.deflection,     inputs.velocity,
                       inputs.curvature, inputs.curvature_rate, inputs.time};
        std::ranges::copy(parameters, parameters_.begin());
        const double value = parser_.Eval();
        if (!std::isfinite(value))
            throw core::NumericalError(core::FailureKind::UserExpression, complaint(value));
        return value;
    }

  private:
    [[nodiscard]] std::string complaint(double value) const {
        std::string names;
        for (std::size_t k = 0; k < variables_.size(); ++k)
            names += fmt::format("{}{} = {:.6g}", k == 0 ? "" : ", ", variables_[k], inputs_[k]);
        for (std::size_t k = 0; k < parameters_.size(); ++k)
            names += fmt::format(", {} = {:.6g}", text_.parameters[k], parameters_[k]);
        return fmt::format("effect {}: {} is {} at {}", text_.effect, text_.formula,
                           std::isnan(value) ? "not a number" : "infinite", names);
    }

    ExpressionText text_;
    std::vector<std::string> variables_;
    std::array<double, 6> inputs_{};
    std::vector<double> parameters_;
    mu::Parser parser_;
    std::mutex mutex_;
};

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

std::vector<std::string> expression_variables(UserLawKind kind) {
    if (kind == UserLawKind::BaseMoment)
        return {"theta", "omega", "t"};
    return {"s", "x", "v", "kappa", "kappa_rate", "t"};
}

std::vector<std::string> expression_functions() {
    std::vector<std::string> names(one_argument.begin(), one_argument.end());
    names.emplace_back("min");
    names.emplace_back("max");
    return names;
}

std::shared_ptr<const UserExpression> compile_expression(const ExpressionText& text) {
    const auto compiled = std::make_shared<CompiledExpression>(text);
    return std::make_shared<const UserExpression>(
        [compiled](const UserLawInputs& inputs, std::span<const double> parameters) {
            return compiled->value(inputs, parameters);
        });
}

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
