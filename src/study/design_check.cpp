// SPDX-License-Identifier: BSD-3-Clause
#include "study/design_check.hpp"

#include "core/error.hpp"
#include "study/case_constraints.hpp"

#include <fmt/format.h>

namespace culm::study {

namespace {

std::optional<std::string> fault_of(const run::CaseSpec& spec, const CaseCheck& further) {
    if (const auto violation = first_violation(spec))
        return fmt::format("{} = {}: {}", violation->key, violation->value, violation->allowed);
    return further ? further(spec) : std::nullopt;
}

std::string factors_text(const Design& design, std::int64_t point) {
    std::string text;
    for (std::size_t column = 0; column < design.factors.size(); ++column) {
        const Parameter& parameter = *design.factors[column].parameter;
        text += fmt::format("{}{} = {:.6g}", text.empty() ? "" : ", ", parameter.key,
                            parameter.unit.from_si(design.row(point)[column]));
    }
    return text.empty() ? text : " (" + text + ")";
}

} // namespace

void check_points(const StudyConfig& config, const Design& design, const CaseCheck& further) {
    constexpr std::int64_t most_listed = 10;
    std::int64_t bad = 0;
    std::string list;
    for (std::int64_t point = 0; point < design.point_count(); ++point) {
        const auto fault = fault_of(case_of_point(config, design, point), further);
        if (!fault)
            continue;
        ++bad;
        if (bad <= most_listed)
            list += fmt::format("\n  point {}: {}{}", point, *fault, factors_text(design, point));
    }
    if (bad == 0)
        return;
    if (bad > most_listed)
        list += fmt::format("\n  and {} more", bad - most_listed);
    throw core::InputError(fmt::format("{}: {} of {} points are impossible:{}", config.file, bad,
                                       design.point_count(), list));
}

} // namespace culm::study
