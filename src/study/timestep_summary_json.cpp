// SPDX-License-Identifier: BSD-3-Clause
// summary.json of a time-step study.
#include "study/summary_json.hpp"
#include "study/timestep_summary.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

namespace culm::study {
namespace {

using nlohmann::json;

/// Smallest, median and largest of what a function says of the stems.
json spread(const std::vector<TimestepStem>& stems,
            const std::function<double(const TimestepStem&)>& value) {
    std::vector<double> values;
    for (const TimestepStem& stem : stems)
        if (const double x = value(stem); std::isfinite(x))
            values.push_back(x);
    if (values.empty())
        return nullptr;
    std::ranges::sort(values);
    const std::size_t middle = values.size() / 2;
    const double median =
        values.size() % 2 == 1 ? values[middle] : 0.5 * (values[middle - 1] + values[middle]);
    return {{"smallest", values.front()}, {"median", median}, {"largest", values.back()}};
}

json limits(const TimestepSummary& summary) {
    const auto& stems = summary.stems;
    const auto axial = std::ranges::count_if(
        stems, [](const TimestepStem& stem) { return stem.axial <= stem.transverse; });
    return {{"axial", axial},
            {"transverse", static_cast<std::int64_t>(stems.size()) - axial},
            {"bisected_over_linearised",
             spread(stems, [](const TimestepStem& s) { return s.limit() / s.linearised(); })},
            {"rule_over_bisected",
             spread(stems, [](const TimestepStem& s) { return s.rule / s.limit(); })}};
}

json law(const reduce::TimestepLawOutcome& outcome, const char* form) {
    if (!outcome.law)
        return {{"form", form}, {"reason", outcome.reason}};
    json coefficients = json::array();
    for (const reduce::Coefficient& coefficient : outcome.law->regression.coefficients)
        coefficients.push_back(term_json(coefficient));
    return {{"form", form},
            {"points", outcome.law->residuals.size()},
            {"coefficients", coefficients},
            {"largest_residual", number_json(outcome.law->largest_residual)}};
}

/// One fraction over all stems.
json errors_at(const TimestepSummary& summary, std::size_t k) {
    const auto count = [&](StepOutcome outcome) {
        return std::ranges::count_if(summary.stems, [&](const TimestepStem& stem) {
            return stem.steps[k].outcome == outcome;
        });
    };
    const auto of_step = [&](double StepResult::*member) {
        return spread(summary.stems,
                      [=](const TimestepStem& s) { return std::abs(s.steps[k].*member); });
    };
    return {{"fraction", summary.options.fractions[k]},
            {"fitted", count(StepOutcome::Fitted)},
            {"unstable", count(StepOutcome::Unstable)},
            {"no_fit", count(StepOutcome::NoFit)},
            {"decay_error", of_step(&StepResult::decay_error)},
            {"frequency_error", of_step(&StepResult::frequency_error)},
            {"predicted_decay_error", of_step(&StepResult::predicted_decay_error)},
            {"predicted_frequency_error", of_step(&StepResult::predicted_frequency_error)}};
}

json errors(const TimestepSummary& summary) {
    json out = json::array();
    for (std::size_t k = 0; k < summary.options.fractions.size(); ++k)
        out.push_back(errors_at(summary, k));
    return out;
}

} // namespace

json to_json(const TimestepSummary& summary) {
    json failed = json::array();
    for (const FailedPoint& point : summary.failed)
        failed.push_back({{"point", point.point}, {"kind", point.kind}, {"reason", point.reason}});
    const auto& laws = summary.regression;
    json out{
        {"kind", "timestep"},
        {"points", summary.points},
        {"completed", summary.stems.size()},
        {"failed", failed},
        {"ranks", summary.ranks},
        {"wall_s", summary.wall_s},
        {"limits", limits(summary)},
        {"regression",
         {{"damped_oscillator", law(laws.damped_oscillator, "(tau/dt)^2 = A + B beta (tau/dt)")},
          {"rule_form", law(laws.rule_form, "dt = tau/(a + b beta)")},
          {"power_law", law(laws.power_law, "ln dt = ln_c + p ln Y + q ln beta")}}},
        {"errors", errors(summary)}};
    if (!summary.options.fractions.empty())
        out["implicit_against_converged"] = {
            {"decay", spread(summary.stems,
                             [](const TimestepStem& s) {
                                 return std::abs(s.reference_decay / s.converged_decay - 1.0);
                             })},
            {"frequency", spread(summary.stems, [](const TimestepStem& s) {
                 return std::abs(s.reference_frequency / s.converged_frequency - 1.0);
             })}};
    return out;
}

} // namespace culm::study
