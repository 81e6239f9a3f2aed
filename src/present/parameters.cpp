// SPDX-License-Identifier: BSD-3-Clause
#include "present/parameters.hpp"

#include "present/files.hpp"
#include "reduce/distributions.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace culm::present {

using nlohmann::json;

json estimate_json(double value, double standard_error) {
    const double half = reduce::normal_quantile_95 * standard_error;
    return {{"value", number(value)},
            {"stderr", number(standard_error)},
            {"interval", {number(value - half), number(value + half)}}};
}

std::string plus_minus(double value, double standard_error, double scale, int decimals) {
    return fmt::format("{:.{}f} ± {:.{}f}", scale * value, decimals,
                       scale * reduce::normal_quantile_95 * standard_error, decimals);
}

std::string parameter_key(const fit::FittedParameter& parameter) {
    const std::size_t at = std::min(parameter.name.find('@'), parameter.name.size());
    std::string key = parameter.name.substr(0, at);
    if (key.find('.') == std::string::npos && !parameter.unit.empty())
        key += parameter.unit == "Pa" ? "_pa" : "_" + parameter.unit;
    return key + parameter.name.substr(at);
}

std::map<std::string, const fit::FittedParameter*>
by_key(std::span<const fit::FittedParameter> parameters) {
    std::map<std::string, const fit::FittedParameter*> sorted;
    for (const fit::FittedParameter& parameter : parameters)
        sorted[parameter_key(parameter)] = &parameter;
    return sorted;
}

json parameters_json(std::span<const fit::FittedParameter> parameters) {
    json out = json::object();
    for (const auto& [key, parameter] : by_key(parameters)) {
        out[key] = estimate_json(parameter->value, parameter->standard_error);
        out[key]["at_bound"] = parameter->is_at_bound;
    }
    return out;
}

ReadableParameter readable(const fit::FittedParameter& parameter) {
    const std::string_view name = parameter.name;
    const auto is = [name](std::string_view quantity) {
        return name == quantity || name.starts_with(std::string(quantity) + '@');
    };
    if (is("bond_youngs_modulus"))
        return parameter.value < 1e8 ? ReadableParameter{parameter.name, 1e-6, "MPa"}
                                     : ReadableParameter{parameter.name, 1e-9, "GPa"};
    if (is("tip_deflection"))
        return {parameter.name, 1e3, "mm"};
    if (is("release_time"))
        return {parameter.name, 1e3, "ms"};
    return {parameter_key(parameter)};
}

std::string value_text(const fit::FittedParameter& parameter) {
    const ReadableParameter shown = readable(parameter);
    const double value = shown.scale * parameter.value;
    const double half = shown.scale * reduce::normal_quantile_95 * parameter.standard_error;
    const bool is_known = std::isfinite(half) && half > 0.0;
    const int digits =
        is_known
            ? std::clamp(static_cast<int>(std::ceil(std::log10(std::abs(value) / half))) + 2, 3, 7)
            : 5;
    std::string text = fmt::format("{:.{}g}", value, digits);
    if (is_known)
        text += fmt::format(" ± {:.2g}", half);
    if (!shown.unit.empty())
        text += fmt::format(" {}", shown.unit);
    return text + (parameter.is_at_bound ? "  (at its bound)" : "");
}

std::string model_name(const std::vector<std::string>& names) {
    return fmt::format("{}", fmt::join(names, " + "));
}

std::string_view finding_text(diagnose::Finding finding) {
    switch (finding) {
    case diagnose::Finding::Adequate:
        return "fits";
    case diagnose::Finding::Inadequate:
        return "something is missing";
    case diagnose::Finding::Undecided:
        break;
    }
    return "cannot tell";
}

std::string finding_text(diagnose::Finding finding, const TextStyle& style) {
    const std::string_view text = finding_text(finding);
    switch (finding) {
    case diagnose::Finding::Adequate:
        return style.good(text);
    case diagnose::Finding::Inadequate:
        return style.warning(text);
    case diagnose::Finding::Undecided:
        break;
    }
    return std::string(text);
}

json tests_json(std::span<const calibrate::LackOfFitTest> tests) {
    json out = json::array();
    for (const calibrate::LackOfFitTest& test : tests)
        out.push_back({{"name", test.name},
                       {"p_value", number(test.p_value)},
                       {"adjusted_p_value", number(test.adjusted_p_value)}});
    return out;
}

} // namespace culm::present
