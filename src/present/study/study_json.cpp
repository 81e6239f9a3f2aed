// SPDX-License-Identifier: BSD-3-Clause
#include "core/describe.hpp"
#include "core/user_files.hpp"
#include "present/study/study.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <functional>
#include <map>
#include <ranges>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <fmt/ostream.h>

namespace culm::present {
namespace {

using study::StepOutcome;
using study::StepResult;
using study::StudyFolder;
using study::StudySummary;
using study::TimestepStem;
using study::TimestepSummary;

/// A law of the paper, or the reason why the points do not determine it.
template <class To>
void describe_law(To& to, const reduce::RegressionOutcome& outcome, const char* predictor,
                  const char* unit) {
    to.when(!outcome.regression, [&] { to("reason", outcome.reason); });
    to.when(outcome.regression, [&](const reduce::ResponseRegression& law) {
        to("predictor", predictor);
        to("unit", unit);
        to("points", law.points);
        to("intercept", law.single.intercept.value);
        to("slope", law.single.slope.value);
        to.object("interval", [&] {
            to("intercept", law.single.intercept.interval());
            to("slope", law.single.slope.interval());
        });
        to("adjusted_r2", law.single.regression.adjusted_r_squared);
        to("largest_residual_percent", law.single.largest_residual);
        to(
            "terms",
            [&] {
                return law.reduced ? law.reduced->model.regression.coefficients
                                   : std::vector<reduce::Coefficient>();
            },
            "that the F-tests kept");
        to.when(law.reduced, [&](const reduce::ReducedModel& reduced) {
            to("terms_adjusted_r2", reduced.model.regression.adjusted_r_squared);
            to("adjusted_r2_full", reduced.model.full_adjusted_r_squared);
            to("single_against_full", reduced.single_predictor_against_full);
        });
        to.when(!law.reduced, [&] { to("terms_reason", law.no_reduced_reason); });
    });
}

template <class To>
void describe_shares(To& to, const reduce::VarianceShares& found,
                     const std::vector<study::FactorGroup>& groups) {
    to("points", found.points);
    to("columns", found.columns, "of the regression");
    to(
        "rest", [&] { return found.shares.back(); }, "interactions, higher powers and scatter");
    to.list(
        "shares", [&] { return std::views::iota(std::size_t{0}, groups.size()); },
        [&](std::size_t k) {
            to("group", [&] { return groups[k].name; });
            to("share", [&] { return found.shares[k].value; });
            to("interval", [&] { return found.shares[k].interval; });
        });
}

/// A part of the spread of b1 and b2, as far as they have it.
template <class To>
void describe_responses(To& to, const study::ReplicateSummary& summary,
                        auto study::ResponseSpread::*part, const auto& members) {
    for (const char* name : {"decay_per_cycle", "frequency"}) {
        decltype(std::optional(study::ResponseSpread().*part)) found;
        for (const study::ResponseSpread& response : summary.responses)
            if (response.name == name)
                found = response.*part;
        to.when(found, [&](const auto& of) { to.object(name, [&] { members(of); }); });
    }
}

template <class To>
void describe_spread(To& to, const study::ReplicateSummary& summary) {
    using study::ResponseSpread;
    const auto all_members = [&](const auto& of) { describe(to, of); };
    const bool has_components =
        std::ranges::any_of(summary.responses, [](const auto& of) { return bool(of.components); });
    to.object("population",
              [&] { describe_responses(to, summary, &ResponseSpread::population, all_members); });
    to.when(has_components, [&] {
        to.object("variance_components", [&] {
            to.constant("method", "one-way random effects, unweighted means");
            describe_responses(to, summary, &ResponseSpread::components, all_members);
        });
    });
    to.object("variance_shares", [&] {
        const std::string& reason = summary.no_shares_reason;
        to.when(!reason.empty(), [&] { to("reason", reason); });
        to.when(reason.empty(), [&] {
            to.constant("method", "additive regression, linear and square of each factor");
            describe_responses(to, summary, &ResponseSpread::variance_shares,
                               [&](const auto& of) { describe_shares(to, of, summary.groups); });
            to.list("groups", summary.groups, [&](const study::FactorGroup& group) {
                to("name", group.name);
                to("factors", group.factors);
            });
        });
    });
}

/// Smallest, median and largest value of a function of a stem; null without values.
template <class To>
void describe_range(To& to, const char* key, const std::vector<TimestepStem>& stems,
                    const std::function<double(const TimestepStem&)>& value) {
    std::vector<double> sorted;
    for (const TimestepStem& stem : stems)
        if (const double x = value(stem); std::isfinite(x))
            sorted.push_back(x);
    std::ranges::sort(sorted);
    to.maybe(key, !sorted.empty(), [&] {
        to("smallest", [&] { return sorted.front(); });
        to("median", [&] { return reduce::quantile(sorted, 0.5); });
        to("largest", [&] { return sorted.back(); });
    });
}

template <class To>
void describe_limits(To& to, const std::vector<TimestepStem>& stems) {
    const auto axial = [&] {
        return std::ranges::count_if(
            stems, [](const TimestepStem& stem) { return stem.axial <= stem.transverse; });
    };
    to("axial", axial, "stems whose limit is that of axial waves");
    to("transverse", [&] { return std::ssize(stems) - axial(); });
    describe_range(to, "bisected_over_linearised", stems,
                   [](const TimestepStem& s) { return s.limit() / s.linearised(); });
    describe_range(to, "rule_over_bisected", stems,
                   [](const TimestepStem& s) { return s.rule / s.limit(); });
}

template <class To>
void describe_limit_law(To& to, const char* key, const reduce::TimestepLawOutcome& outcome,
                        const char* form) {
    to.object(key, [&] {
        to("form", form);
        to.when(!outcome.law, [&] { to("reason", outcome.reason); });
        to.when(outcome.law, [&](const reduce::TimestepLaw& law) {
            to("points", [&] { return law.residuals.size(); });
            to("coefficients", law.regression.coefficients);
            to("largest_residual", law.largest_residual);
        });
    });
}

/// One fraction over all stems.
template <class To>
void describe_errors_at(To& to, const TimestepSummary& summary, std::size_t k) {
    const auto add = [&](const char* key, double StepResult::*member) {
        describe_range(to, key, summary.stems,
                       [=](const TimestepStem& s) { return std::abs(s.steps[k].*member); });
    };
    to("fraction", [&] { return summary.options.fractions[k]; });
    to("fitted", [&] { return summary.count(k, StepOutcome::Fitted); });
    to("unstable", [&] { return summary.count(k, StepOutcome::Unstable); });
    to("no_fit", [&] { return summary.count(k, StepOutcome::NoFit); });
    add("decay_error", &StepResult::decay_error);
    add("frequency_error", &StepResult::frequency_error);
}

/// The members that the summaries of all kinds of studies have.
template <class To>
void describe_run(To& to, const study::SummaryOfRun& run) {
    to("points", run.points, "of the design");
    to("stem", run.stem, "of the first point, for a check by hand");
    to.list("failed", run.failed, [&](const study::FailedPoint& failed) {
        to("point", failed.point);
        to("kind", failed.kind);
        to("reason", failed.reason);
    });
    to("ranks", run.ranks);
    to("wall_s", run.wall_s);
    to.when(!run.missing.empty(),
            [&] { to("missing", run.missing, "points that were not computed"); });
}

/// summary.json of a study of vibrations.
struct StudySummaryFile {
    core::Viewed<StudySummary> summary;
};
template <class To>
void describe(To& to, const StudySummaryFile& of) {
    const StudySummary& summary = *of.summary;
    describe_run(to, summary);
    to("completed", summary.completed);
    to.object("integrator", [&] {
        to("method", summary.integrator, "with its tolerance or step");
        to("work", [&] {
            std::map<std::string, std::int64_t> work;
            for (const auto& [name, sum] : summary.work)
                work[name] = std::llround(sum);
            return work;
        });
    });
    to.object("fit", [&] {
        to("window_s", summary.reduce.window, "null: the whole record");
        to("amplitude", [&] { return summary.reduce.is_amplitude_free ? "free" : "fixed"; });
        to("significance", summary.reduce.significance);
    });
    to("is_published_stem", summary.is_published,
       "Eqs. 12 and 13 belong to its stem and law; only Y and beta vary");
    to.object("regression", [&] {
        to.object("sqrt_youngs_modulus", [&] {
            describe_law(to, summary.regression.sqrt_youngs_modulus, "frequency", "sqrt(Pa)");
        });
        to.object("bond_damping", [&] {
            describe_law(to, summary.regression.bond_damping, "decay_per_cycle", "1");
        });
    });
    to.when(summary.replicates, [&](const auto& replicates) { describe_spread(to, replicates); });
}

/// summary.json of a time-step study.
struct TimestepSummaryFile {
    core::Viewed<TimestepSummary> summary;
};
template <class To>
void describe(To& to, const TimestepSummaryFile& of) {
    const TimestepSummary& summary = *of.summary;
    const reduce::TimestepRegression& laws = summary.regression;
    const std::vector<double>& fractions = summary.options.fractions;
    describe_run(to, summary);
    to.constant("kind", "timestep");
    to("completed", [&] { return summary.stems.size(); });
    to.object("limits", [&] { describe_limits(to, summary.stems); });
    to.object("regression", [&] {
        describe_limit_law(to, "damped_oscillator", laws.damped_oscillator,
                           "(tau/dt)^2 = A + B beta (tau/dt)");
        describe_limit_law(to, "rule_form", laws.rule_form, "dt = tau/(a + b beta)");
    });
    to.list(
        "errors", [&] { return std::views::iota(std::size_t{0}, fractions.size()); },
        [&](std::size_t k) { describe_errors_at(to, summary, k); });
    to.when(!fractions.empty(), [&] {
        to.object("implicit_against_converged", [&] {
            describe_range(to, "decay", summary.stems, [](const TimestepStem& s) {
                return std::abs(s.reference_decay / s.converged_decay - 1.0);
            });
            describe_range(to, "frequency", summary.stems, [](const TimestepStem& s) {
                return std::abs(s.reference_frequency / s.converged_frequency - 1.0);
            });
        });
    });
}

} // namespace

nlohmann::json summary_json(const StudySummary& summary) {
    return core::json_of(StudySummaryFile{summary});
}

nlohmann::json summary_json(const TimestepSummary& summary) {
    return core::json_of(TimestepSummaryFile{summary});
}

nlohmann::json summary_schema() {
    return {
        {"oneOf", {core::schema_of<StudySummaryFile>(), core::schema_of<TimestepSummaryFile>()}}};
}

void write_summary(const StudyFolder& folder, const study::StudySummary& summary) {
    core::write_text(folder.path() / "summary.json", summary_json(summary).dump(2) + '\n');
    const std::filesystem::path path = folder.path() / "fits.csv";
    std::ofstream csv(path);
    fmt::print(csv, "point,bond_youngs_modulus_pa,bond_damping,decay_per_cycle,frequency_hz\n");
    for (std::size_t k = 0; k < summary.frequency.size(); ++k)
        fmt::print(csv, "{},{},{},{},{}\n", k, summary.youngs_modulus[k], summary.bond_damping[k],
                   summary.decay_per_cycle[k], summary.frequency[k]);
    core::require_written(csv, path);
}

void write_summary(const StudyFolder& folder, const TimestepSummary& summary) {
    core::write_text(folder.path() / "summary.json", summary_json(summary).dump(2) + '\n');
}

} // namespace culm::present
