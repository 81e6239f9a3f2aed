// SPDX-License-Identifier: BSD-3-Clause
#include "present/calibration.hpp"
#include "present/parameters.hpp"
#include "present/text.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace culm::present {
namespace {

/// How inputs of a unit are shown, as in stem.toml's keys.
struct Shown {
    std::string_view si_unit;
    double scale;
    const char* unit;
};

Shown shown(const fit::StatedInput& input) {
    static constexpr Shown units[]{{"m", 1e3, " mm"}, {"m²", 1e6, " mm²"}, {"m⁴", 1e12, " mm⁴"},
                                   {"kg", 1e3, " g"}, {"", 100.0, " %"},   {"1", 1.0, ""}};
    const auto* found = std::ranges::find(units, input.unit, &Shown::si_unit);
    return found != std::end(units) ? *found : Shown{input.unit, 1.0, " kg/m³"};
}

/// "-" for the inputs of picture and clock, which are corrections without a stated value.
std::string stated_text(const fit::StatedInput& input) {
    const Shown in = shown(input);
    return input.value == 0.0 ? "-" : fmt::format("{:.5g}{}", in.scale * input.value, in.unit);
}

std::string uncertainty_text(const fit::StatedInput& input) {
    const Shown in = shown(input);
    return fmt::format("{:.3g}{}{}", in.scale * input.standard_uncertainty, in.unit,
                       input.is_default ? " *" : "  ");
}

/// Tip deflection, release time and error terms are omitted: they describe only this recording.
std::vector<std::size_t> tabulated_parameters(std::span<const fit::FittedParameter> parameters) {
    std::vector<std::size_t> places;
    for (std::size_t p = 0; p < parameters.size(); ++p)
        if (const physics::ParameterId id = parameters[p].id.in_one_model();
            !physics::is_of_release(id) && !parameters[p].is_error)
            places.push_back(p);
    return places;
}

/// c u of an input relative to the value, and its share of the variance.
std::string contribution(double uncertainty, double value, double share) {
    if (!std::isfinite(uncertainty))
        return fmt::format("{:>24}", "not told");
    return fmt::format("{:>+13.3f} % {:>6.1f} %", 100.0 * uncertainty / std::abs(value),
                       100.0 * share);
}

/// A standard uncertainty relative to the value.
std::string share_of_value(double uncertainty, double value) {
    return std::isfinite(uncertainty)
               ? fmt::format("{:>13.3f} %{:9}", 100.0 * uncertainty / std::abs(value), "")
               : fmt::format("{:>24}", "not told");
}

std::string table_line(const std::string& name, const std::string& stated, const std::string& u,
                       const std::string& pull) {
    return fmt::format("    {:<22} {:>12} {:>12} {:>6}", name, stated, u, pull);
}

} // namespace

std::string defaults_sentence(const fit::UncertaintyBudget& budget) {
    std::vector<std::string> defaults;
    for (const fit::BudgetInput& line : budget.inputs)
        if (line.input.is_default)
            defaults.push_back(line.input.name);
    return defaults.empty() ? std::string()
                            : fmt::format("No uncertainty is stated for {}: the defaults are "
                                          "used.",
                                          fmt::join(defaults, ", "));
}

std::string budget_text(const fit::UncertaintyBudget& budget,
                        std::span<const fit::FittedParameter> parameters) {
    const std::vector<std::size_t> places = tabulated_parameters(parameters);
    std::string text = "  uncertainty budget (standard uncertainties; * none stated; share of the "
                       "variance)\n" +
                       table_line("input", "stated", "u", "pull");
    for (const std::size_t p : places)
        text += fmt::format(" {:>23}", readable(parameters[p]).name);
    text += '\n';
    for (std::size_t k = 0; k < budget.inputs.size(); ++k) {
        const fit::BudgetInput& line = budget.inputs[k];
        text += table_line(line.input.name, stated_text(line.input), uncertainty_text(line.input),
                           fmt::format("{:+.1f}", line.pull));
        for (const std::size_t p : places)
            text += contribution(line.sensitivities[p] * line.input.standard_uncertainty,
                                 parameters[p].value, budget.share(k, p));
        text += '\n';
    }
    text += table_line("noise of the readings", "", "", "");
    for (const std::size_t p : places)
        text +=
            contribution(budget.from_readings[p], parameters[p].value, budget.share_of_readings(p));
    text += '\n' + table_line("combined", "", "", "");
    for (const std::size_t p : places)
        text += share_of_value(budget.combined[p], parameters[p].value);
    text.erase(text.find_last_not_of(' ') + 1);
    text += '\n';
    if (const std::string defaults = defaults_sentence(budget); !defaults.empty())
        text += result_lines("    ", defaults);
    return text;
}

std::string largest_shares_text(const fit::UncertaintyBudget& budget,
                                std::span<const fit::FittedParameter> parameters) {
    constexpr double enough = 0.9;
    std::string text;
    for (const std::size_t p : tabulated_parameters(parameters)) {
        std::vector<std::pair<double, std::string>> shares{
            {budget.share_of_readings(p), "noise of the readings"}};
        for (std::size_t k = 0; k < budget.inputs.size(); ++k)
            shares.emplace_back(budget.share(k, p), budget.inputs[k].input.name);
        std::ranges::stable_sort(shares, std::greater{}, &std::pair<double, std::string>::first);
        std::vector<std::string> causes;
        double sum = 0.0;
        for (const auto& [share, name] : shares)
            if (sum < enough && share > 0.0) { // false for NaN
                causes.push_back(fmt::format("{} {:.0f} %", name, 100.0 * share));
                sum += share;
            }
        if (!causes.empty())
            text += result_lines("  ", fmt::format("Uncertainty of {}: {} of the variance.",
                                                   readable(parameters[p]).name,
                                                   fmt::join(causes, ", ")));
    }
    if (const std::string defaults = defaults_sentence(budget); !defaults.empty())
        text += result_lines("  ", defaults);
    return text;
}

} // namespace culm::present
