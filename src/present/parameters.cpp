// SPDX-License-Identifier: BSD-3-Clause
#include "present/parameters.hpp"

#include "present/files.hpp"
#include "reduce/distributions.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace culm::present {

std::string with_uncertainty(double value, double half) {
    if (!std::isfinite(half) || half <= 0.0)
        return fmt::format("{:.5g}", value);
    // Two significant digits of 0.0996 are 0.10.
    const int place = static_cast<int>(std::floor(std::log10(half * (1.0 + 0.5e-2))));
    if (place >= 4 || place < -6) {
        const double digits = std::ceil(std::log10(std::abs(value) / half)) + 2.0;
        return fmt::format("{:.{}g} ± {:.2g}", value, std::clamp(static_cast<int>(digits), 2, 9),
                           half);
    }
    const int decimals = std::max(0, 1 - place);
    return fmt::format("{:.{}f} ± {:.{}f}", value, decimals, half, decimals);
}

std::string plus_minus(const reduce::Estimate& estimate, double scale) {
    return with_uncertainty(scale * estimate.value, scale * (estimate.upper - estimate.value));
}

std::string parameter_key(const fit::FittedParameter& parameter) {
    std::string key = to_string(parameter.id.in_one_model());
    if (!parameter.id.is_of_effect() && !parameter.unit.empty())
        key += parameter.unit == "Pa" ? "_pa" : "_" + parameter.unit;
    return parameter.id.is_one_recordings_own() ? key + "@" + parameter.id.recording : key;
}

std::map<std::string, const fit::FittedParameter*>
by_key(std::span<const fit::FittedParameter> parameters) {
    std::map<std::string, const fit::FittedParameter*> sorted;
    for (const fit::FittedParameter& parameter : parameters)
        if (!parameter.is_error)
            sorted[parameter_key(parameter)] = &parameter;
    return sorted;
}

std::map<std::string, ShownParameter>
shown_parameters(std::span<const fit::FittedParameter> parameters) {
    std::map<std::string, ShownParameter> shown;
    for (const auto& [key, parameter] : by_key(parameters))
        shown[key] = {reduce::normal_estimate(parameter->value, parameter->standard_error),
                      parameter->unit, parameter->is_at_bound};
    return shown;
}

ReadableParameter readable(const fit::FittedParameter& parameter) {
    const physics::ParameterId id = parameter.id.in_one_model();
    const std::string name = to_string(parameter.id);
    if (id == physics::bond_youngs_modulus)
        return parameter.value < 1e8 ? ReadableParameter{name, 1e-6, "MPa"}
                                     : ReadableParameter{name, 1e-9, "GPa"};
    if (physics::is_of_release(id) && parameter.unit == "m")
        return {name, 1e3, "mm"};
    if (physics::is_of_release(id) && parameter.unit == "m/s")
        return {name, 1e3, "mm/s"};
    if (id == physics::release_time)
        return {name, 1e3, "ms"};
    return {parameter_key(parameter)};
}

std::string value_text(const fit::FittedParameter& parameter) {
    const ReadableParameter shown = readable(parameter);
    std::string text =
        plus_minus(reduce::normal_estimate(parameter.value, parameter.standard_error), shown.scale);
    if (!shown.unit.empty())
        text += fmt::format(" {}", shown.unit);
    return text + (parameter.is_at_bound ? "  (at its bound)" : "");
}

std::string model_name(const std::vector<std::string>& names) {
    return fmt::format("{}", fmt::join(names, " + "));
}

std::string contradiction_sentence(std::span<const fit::Pull> all, bool describes_readings) {
    std::vector<std::string> pulls;
    double largest = 0.0;
    for (const auto& [name, pull] : contradictions_of(all)) {
        pulls.push_back(fmt::format("{} {:+.1f}", name, pull));
        largest = std::max(largest, std::abs(pull));
    }
    if (pulls.empty())
        return {};
    if (!describes_readings)
        return fmt::format("The model is wrong: it moves stated inputs by up to {:.1f} standard "
                           "uncertainties and still does not describe the readings.",
                           largest);
    return fmt::format("Contradicted inputs, in standard uncertainties: {}. Either they are wrong, "
                       "or the model lacks an effect. The tests were made with the inputs moved.",
                       fmt::join(pulls, ", "));
}

std::vector<Contradiction> contradictions_of(std::span<const fit::Pull> pulls) {
    std::vector<Contradiction> found;
    for (const fit::Pull& pull : pulls)
        if (std::abs(pull.value) > fit::contradiction)
            found.push_back({pull.id, pull.value});
    return found;
}

std::vector<std::string> remarks_on(const fit::RecordingFit& part) {
    std::vector<std::string> remarks = part.model.remarks;
    std::ranges::copy(part.missing_terms, std::back_inserter(remarks));
    return remarks;
}

} // namespace culm::present
