// SPDX-License-Identifier: BSD-3-Clause
#include "core/user_files.hpp"
#include "present/files.hpp"
#include "present/study/study.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <functional>
#include <vector>

#include <fmt/format.h>
#include <fmt/ostream.h>

namespace culm::present {
namespace {

using nlohmann::json;
using study::StepOutcome;
using study::StepResult;
using study::StudyFolder;
using study::TimestepStem;
using study::TimestepSummary;

json histogram(const reduce::ResidualSummary& residuals) {
    return {{"edges", residuals.histogram.edges}, {"counts", residuals.histogram.counts}};
}

json term_json(const reduce::Coefficient& coefficient) {
    return {{"term", coefficient.name},
            {"coefficient", number(coefficient.value)},
            {"standard_error", number(coefficient.standard_error)},
            {"interval", bounds_json(coefficient)},
            {"p_value", number(coefficient.p_value)}};
}

json to_json(const reduce::RegressionOutcome& outcome, const char* predictor, const char* unit) {
    if (!outcome.regression)
        return {{"reason", outcome.reason}};
    const reduce::ResponseRegression& response = *outcome.regression;
    json out{
        {"predictor", predictor},
        {"unit", unit},
        {"points", response.points},
        {"intercept", number(response.single.intercept.value)},
        {"slope", number(response.single.slope.value)},
        {"interval",
         {{"intercept", bounds_json(response.single.intercept)},
          {"slope", bounds_json(response.single.slope)}}},
        {"adjusted_r2", number(response.single.regression.adjusted_r_squared)},
        {"residuals_percent", histogram(response.single.residuals)},
    };
    out["terms"] = json::array();
    if (response.reduced) {
        out["terms"] = array_of(response.reduced->model.regression.coefficients, term_json);
        out["terms_adjusted_r2"] = number(response.reduced->model.regression.adjusted_r_squared);
        out["adjusted_r2_full"] = number(response.reduced->model.full_adjusted_r_squared);
        out["terms_residuals_percent"] = histogram(response.reduced->residuals);
        const auto& test = response.reduced->single_predictor_against_full;
        out["single_against_full"] = {{"f", number(test.f_statistic)},
                                      {"p_value", number(test.p_value)}};
    } else {
        out["terms_reason"] = response.no_reduced_reason;
    }
    return out;
}

json to_json(const reduce::VarianceComponents& c) {
    json out{{"stems", c.stems},
             {"tests", c.tests},
             {"between",
              {{"variance", number(c.between)},
               {"interval", bounds_json(c.between_interval)},
               {"degrees_of_freedom", c.between_degrees_of_freedom}}},
             {"within",
              {{"variance", number(c.within)},
               {"interval", bounds_json(c.within_interval)},
               {"degrees_of_freedom", c.within_degrees_of_freedom}}},
             {"intraclass_correlation",
              {{"value", number(c.intraclass_correlation)},
               {"interval", bounds_json(c.intraclass_interval)}}},
             {"f", number(c.f_statistic)},
             {"p_value", number(c.p_value)}};
    if (!c.reason.empty())
        out["reason"] = c.reason;
    return out;
}

json to_json(const reduce::Share& share) {
    return {{"value", number(share.value)}, {"interval", bounds_json(share.interval)}};
}

json to_json(const reduce::Sensitivity& sensitivity, std::int64_t designed) {
    if (!sensitivity.is_determined())
        return {
            {"reason", fmt::format("polynomials of the factors predict nothing at points that are "
                                   "left out of {}",
                                   sensitivity.points)}};
    const auto indices = [](const reduce::GroupSensitivity& group) -> json {
        return {{"group", group.name},
                {"first_order", to_json(group.first_order)},
                {"total", to_json(group.total)}};
    };
    return {{"points", sensitivity.points},
            {"designed_points", designed},
            {"degree", sensitivity.degree},
            {"terms", sensitivity.terms},
            {"predicted_share", number(sensitivity.predicted_share)},
            {"mean", number(sensitivity.mean)},
            {"standard_deviation", number(sensitivity.standard_deviation)},
            {"interactions", number(sensitivity.interactions)},
            {"indices", array_of(sensitivity.groups, indices)}};
}

void add_spread(json& out, const study::ReplicateSummary& summary, std::int64_t designed) {
    json population = json::object();
    json components = json::object();
    json sensitivity = json::object();
    for (const study::ResponseSpread& response : summary.responses) {
        population[response.name] = sample_json(response.population);
        population[response.name]["points"] = response.population.count;
        if (response.components)
            components[response.name] = to_json(*response.components);
        if (response.sensitivity)
            sensitivity[response.name] = to_json(*response.sensitivity, designed);
    }
    out["population"] = population;
    if (!components.empty()) {
        components["method"] = "one-way random effects, unweighted means";
        out["variance_components"] = components;
    }
    if (!summary.no_sensitivity_reason.empty()) {
        out["sensitivity"] = {{"reason", summary.no_sensitivity_reason}};
        return;
    }
    sensitivity["method"] = "polynomial chaos, degree by leave-one-out error";
    sensitivity["groups"] = array_of(summary.groups, [](const study::FactorGroup& group) -> json {
        return {{"name", group.name}, {"factors", group.factors}};
    });
    out["sensitivity"] = sensitivity;
}

/// Smallest, median and largest value of a function of a stem.
json spread_json(const std::vector<TimestepStem>& stems,
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

json limits_json(const TimestepSummary& summary) {
    const auto& stems = summary.stems;
    const auto axial = std::ranges::count_if(
        stems, [](const TimestepStem& stem) { return stem.axial <= stem.transverse; });
    return {{"axial", axial},
            {"transverse", static_cast<std::int64_t>(stems.size()) - axial},
            {"bisected_over_linearised",
             spread_json(stems, [](const TimestepStem& s) { return s.limit() / s.linearised(); })},
            {"rule_over_bisected",
             spread_json(stems, [](const TimestepStem& s) { return s.rule / s.limit(); })}};
}

json law_json(const reduce::TimestepLawOutcome& outcome, const char* form) {
    if (!outcome.law)
        return {{"form", form}, {"reason", outcome.reason}};
    return {{"form", form},
            {"points", outcome.law->residuals.size()},
            {"coefficients", array_of(outcome.law->regression.coefficients, term_json)},
            {"largest_residual", number(outcome.law->largest_residual)}};
}

/// One fraction over all stems.
json errors_at_json(const TimestepSummary& summary, std::size_t k) {
    const auto of_step = [&](double StepResult::*member) {
        return spread_json(summary.stems,
                           [=](const TimestepStem& s) { return std::abs(s.steps[k].*member); });
    };
    return {{"fraction", summary.options.fractions[k]},
            {"fitted", summary.count(k, StepOutcome::Fitted)},
            {"unstable", summary.count(k, StepOutcome::Unstable)},
            {"no_fit", summary.count(k, StepOutcome::NoFit)},
            {"decay_error", of_step(&StepResult::decay_error)},
            {"frequency_error", of_step(&StepResult::frequency_error)},
            {"predicted_decay_error", of_step(&StepResult::predicted_decay_error)},
            {"predicted_frequency_error", of_step(&StepResult::predicted_frequency_error)}};
}

std::string limits_csv(const TimestepSummary& summary) {
    std::string csv = "point,bond_youngs_modulus_pa,bond_damping,stable_s,unstable_s,transverse_s,"
                      "axial_s,rule_s\n";
    for (const TimestepStem& stem : summary.stems)
        csv += fmt::format("{},{},{},{},{},{},{},{}\n", stem.point, stem.youngs_modulus,
                           stem.bond_damping, stem.stable, stem.unstable, stem.transverse,
                           stem.axial, stem.rule);
    return csv;
}

std::string step_errors_csv(const TimestepSummary& summary) {
    constexpr const char* outcomes[] = {"fitted", "unstable", "no_fit"};
    std::string csv = "point,bond_youngs_modulus_pa,bond_damping,fraction,timestep_s,outcome,"
                      "decay_per_cycle,frequency_hz,decay_error,frequency_error,"
                      "predicted_decay_error,predicted_frequency_error\n";
    for (const TimestepStem& stem : summary.stems)
        for (std::size_t k = 0; k < stem.steps.size(); ++k) {
            const StepResult& step = stem.steps[k];
            csv += fmt::format("{},{},{},{},{},{},{},{},{},{},{},{}\n", stem.point,
                               stem.youngs_modulus, stem.bond_damping, summary.options.fractions[k],
                               step.step, outcomes[static_cast<int>(step.outcome)],
                               step.decay_per_cycle, step.frequency, step.decay_error,
                               step.frequency_error, step.predicted_decay_error,
                               step.predicted_frequency_error);
        }
    return csv;
}

/// The members that the summaries of all kinds of studies have.
json run_json(const study::SummaryOfRun& run) {
    const auto failed = [](const study::FailedPoint& point) -> json {
        return {{"point", point.point}, {"kind", point.kind}, {"reason", point.reason}};
    };
    json out{{"points", run.points},
             {"stem", run.stem},
             {"failed", array_of(run.failed, failed)},
             {"ranks", run.ranks},
             {"wall_s", run.wall_s}};
    if (!run.missing.empty())
        out["missing"] = run.missing;
    return out;
}

} // namespace

nlohmann::json to_json(const study::StudySummary& summary) {
    json work = json::object();
    for (const auto& [name, sum] : summary.work)
        work[name] = std::llround(sum);
    json out = run_json(summary);
    out.update(
        {{"completed", summary.completed},
         {"integrator", {{"method", summary.integrator}, {"work", work}}},
         {"fit",
          {{"window_s", summary.reduce.window ? json(*summary.reduce.window) : json(nullptr)},
           {"amplitude", summary.reduce.is_amplitude_free ? "free" : "fixed"},
           {"significance", summary.reduce.significance}}},
         {"regression",
          {{"sqrt_youngs_modulus",
            to_json(summary.regression.sqrt_youngs_modulus, "frequency", "sqrt(Pa)")},
           {"bond_damping", to_json(summary.regression.bond_damping, "decay_per_cycle", "1")}}}});
    if (summary.replicates)
        add_spread(out, *summary.replicates, static_cast<std::int64_t>(summary.points));
    return out;
}

nlohmann::json to_json(const TimestepSummary& summary) {
    const auto& laws = summary.regression;
    json out = run_json(summary);
    out.update({{"kind", "timestep"},
                {"completed", summary.stems.size()},
                {"limits", limits_json(summary)},
                {"regression",
                 {{"damped_oscillator",
                   law_json(laws.damped_oscillator, "(tau/dt)^2 = A + B beta (tau/dt)")},
                  {"rule_form", law_json(laws.rule_form, "dt = tau/(a + b beta)")},
                  {"power_law", law_json(laws.power_law, "ln dt = ln_c + p ln Y + q ln beta")}}},
                {"errors", array_of_count(summary.options.fractions.size(), [&](std::size_t k) {
                     return errors_at_json(summary, k);
                 })}});
    if (!summary.options.fractions.empty())
        out["implicit_against_converged"] = {
            {"decay", spread_json(summary.stems,
                                  [](const TimestepStem& s) {
                                      return std::abs(s.reference_decay / s.converged_decay - 1.0);
                                  })},
            {"frequency", spread_json(summary.stems, [](const TimestepStem& s) {
                 return std::abs(s.reference_frequency / s.converged_frequency - 1.0);
             })}};
    return out;
}

void write_summary(const StudyFolder& folder, const study::StudySummary& summary) {
    core::write_text(folder.path() / "summary.json", to_json(summary).dump(2) + '\n');
    const std::filesystem::path path = folder.path() / "fits.csv";
    std::ofstream csv(path);
    fmt::print(csv, "point,bond_youngs_modulus_pa,bond_damping,decay_per_cycle,frequency_hz\n");
    for (std::size_t k = 0; k < summary.frequency.size(); ++k)
        fmt::print(csv, "{},{},{},{},{}\n", k, summary.youngs_modulus[k], summary.bond_damping[k],
                   summary.decay_per_cycle[k], summary.frequency[k]);
    core::require_written(csv, path);
}

void write_summary(const StudyFolder& folder, const TimestepSummary& summary) {
    core::write_text(folder.path() / "summary.json", to_json(summary).dump(2) + '\n');
    core::write_text(folder.path() / "limits.csv", limits_csv(summary));
    core::write_text(folder.path() / "step_errors.csv", step_errors_csv(summary));
}

} // namespace culm::present
