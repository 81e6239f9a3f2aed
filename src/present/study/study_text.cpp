// SPDX-License-Identifier: BSD-3-Clause
#include "present/study/study.hpp"
#include "study/summary/summary.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <fmt/core.h>

namespace culm::present {
namespace {

/// The missing points, and the first ten failed ones with their reasons; empty if there are none.
/// summary.json lists all.
std::string failed_points_text(const study::SummaryOfRun& summary) {
    constexpr std::size_t listed = 10;
    const std::vector<study::FailedPoint>& failed = summary.failed;
    std::string text;
    if (!summary.missing.empty())
        text = fmt::format("\n{} of {} points were not computed: {}; `culm run STUDY.toml -o DIR "
                           "--resume` computes them\n",
                           summary.missing.size(), summary.points, ranges_text(summary.missing));
    if (failed.empty())
        return text;
    text += fmt::format("\n{} of {} points failed:\n", failed.size(), summary.points);
    for (std::size_t k = 0; k < std::min(listed, failed.size()); ++k)
        text += fmt::format("    point {}: {}: {}\n", failed[k].point, failed[k].kind,
                            failed[k].reason);
    if (failed.size() > listed)
        text += fmt::format("    … and {} more, see summary.json\n", failed.size() - listed);
    return text;
}

/// The paper's name of the response.
std::string short_name(const study::ResponseSpread& response) {
    return response.name == "frequency" ? "b2 in Hz" : "b1 per cycle";
}

std::string number_with_bounds(double value, const reduce::Bounds& interval) {
    return fmt::format("{:.4g} ({:.4g} … {:.4g})", value, interval.lower, interval.upper);
}

std::string root_with_bounds(double value, const reduce::Bounds& interval) {
    return number_with_bounds(std::sqrt(value),
                              {std::sqrt(interval.lower), std::sqrt(interval.upper)});
}

std::string percent_with_bounds(const reduce::Share& share) {
    return fmt::format("{:5.1f} % ({:.1f} … {:.1f})", 100.0 * share.value,
                       100.0 * share.interval.lower, 100.0 * share.interval.upper);
}

std::string population_line(const study::ResponseSpread& response) {
    const reduce::SampleSummary& p = response.population;
    return fmt::format("    {:<14} mean {}, sd {}, 90 % from {:.4g} to {:.4g}\n",
                       short_name(response), number_with_bounds(p.mean, p.mean_interval),
                       number_with_bounds(p.standard_deviation, p.standard_deviation_interval),
                       p.central_90_percent.lower, p.central_90_percent.upper);
}

std::string components_line(const study::ResponseSpread& response) {
    const reduce::VarianceComponents& c = *response.components;
    if (!c.reason.empty())
        return fmt::format("    {:<14} {}\n", short_name(response), c.reason);
    return fmt::format("    {:<14} sd between stems {}, within {}; share between {}\n",
                       short_name(response),
                       root_with_bounds(c.between.variance, c.between.interval),
                       root_with_bounds(c.within.variance, c.within.interval),
                       percent_with_bounds(c.intraclass_correlation));
}

/// One line for each group of factors and one for the rest.
std::string share_lines(const study::ReplicateSummary& summary,
                        const study::ResponseSpread& response) {
    const std::vector<reduce::Share>& shares = response.variance_shares->shares;
    if (std::isnan(shares.back().value))
        return fmt::format("    {:<14} does not vary\n", short_name(response));
    std::string text = fmt::format("    {}\n", short_name(response));
    for (std::size_t k = 0; k < shares.size(); ++k)
        text += fmt::format("        {}  {}\n", percent_with_bounds(shares[k]),
                            k < summary.groups.size() ? summary.groups[k].name
                                                      : "interactions, higher powers, scatter");
    return text;
}

std::string replicate_table(const study::ReplicateSummary& summary, std::size_t failed) {
    if (!summary.has_distributions)
        return {};
    std::string text = fmt::format("\nSpread of {} points (95 % intervals)\n",
                                   summary.responses.front().population.count);
    for (const study::ResponseSpread& response : summary.responses)
        text += population_line(response);
    if (summary.responses.front().components) {
        text += "\nStem to stem, and between tests of one stem (one-way random effects)\n";
        for (const study::ResponseSpread& response : summary.responses)
            text += components_line(response);
    }
    text += "\nWhere the spread comes from (shares of the variance, additive regression)\n";
    if (failed > 0)
        text += fmt::format("    of the {} points that gave a result; {} failed, which is not by "
                            "chance: these are shares in a part of the design\n",
                            summary.responses.front().population.count, failed);
    if (!summary.no_shares_reason.empty())
        return text + fmt::format("    not known: {}\n", summary.no_shares_reason);
    for (const study::ResponseSpread& response : summary.responses)
        text += share_lines(summary, response);
    for (const study::FactorGroup& group : summary.groups)
        if (group.factors.size() > 1)
            text += fmt::format("    {} depend on each other: they have one share\n", group.name);
    return text;
}

/// `published` is the published law, or empty.
std::string law(const char* response, const char* predictor, const std::string& published,
                const reduce::RegressionOutcome& outcome) {
    if (!outcome.regression)
        return fmt::format("{:<10} no regression: {}\n", response, outcome.reason);
    const reduce::ResponseRegression& found = *outcome.regression;
    const auto& slope = found.single.slope;
    const auto& intercept = found.single.intercept;
    std::string text = fmt::format(
        "{} = {:.2f} {} {} {:.2f}      adjusted R² {:.5f}, {} points\n{}"
        "    95 % intervals:     slope {:.2f} … {:.2f}, intercept {:.2f} … {:.2f}\n",
        response, slope.value, predictor, intercept.value < 0 ? "-" : "+",
        std::abs(intercept.value), found.single.regression.adjusted_r_squared, found.points,
        published.empty() ? published : fmt::format("    published:          {}\n", published),
        slope.lower, slope.upper, intercept.lower, intercept.upper);
    text += fmt::format("    largest residual:   {:.2f} % of the largest observed value\n",
                        found.single.largest_residual);
    if (!found.reduced) {
        text += fmt::format("    F-tests:            {}\n", found.no_reduced_reason);
        return text;
    }
    text += "    kept by F-tests:   ";
    for (const auto& term : found.reduced->model.regression.coefficients)
        text += fmt::format(" {:+.5g} {}", term.value, term.name);
    text +=
        fmt::format("  (adjusted R² {:.6f})\n", found.reduced->model.regression.adjusted_r_squared);
    return text;
}

/// Number of stems on the screen; study.h5 has all.
constexpr std::size_t listed_stems = 40;

std::string limits(const study::TimestepSummary& summary) {
    std::string text =
        fmt::format("Largest stable step, bisected to {:.3g}; linearised chain; authors' rule\n\n"
                    "  {:>8} {:>9} {:>13} {:>13} {:>11} {:>13} {:>9}\n",
                    summary.options.limit_tolerance, "Y/GPa", "beta", "bisected/s", "linearised/s",
                    "limited by", "rule/s", "rule/limit");
    for (std::size_t k = 0; k < std::min(listed_stems, summary.stems.size()); ++k) {
        const study::TimestepStem& stem = summary.stems[k];
        text +=
            fmt::format("  {:>8.4g} {:>9.4g} {:>13.4g} {:>13.4g} {:>11} {:>13.4g} {:>9.3f}\n",
                        stem.youngs_modulus * 1e-9, stem.bond_damping, stem.limit(),
                        stem.linearised(), stem.axial <= stem.transverse ? "axial" : "transverse",
                        stem.rule, stem.rule / stem.limit());
    }
    if (summary.stems.size() > listed_stems)
        text += fmt::format("  … and {} more, in study.h5\n", summary.stems.size() - listed_stems);
    return text;
}

std::string law(const char* form, const reduce::TimestepLawOutcome& outcome) {
    if (!outcome.law)
        return fmt::format("  {:<38} no law: {}\n", form, outcome.reason);
    std::string text = fmt::format("  {:<38}", form);
    for (const auto& coefficient : outcome.law->regression.coefficients)
        text += fmt::format(" {} = {:.5g} ({:.5g} … {:.5g})", coefficient.name, coefficient.value,
                            coefficient.lower, coefficient.upper);
    return text +
           fmt::format("; largest residual {:.2f} %\n", 100.0 * outcome.law->largest_residual);
}

std::string laws(const reduce::TimestepRegression& found) {
    return fmt::format(
               "\nLaws of the bisected limit dt, tau = sqrt(m/k_n), {} stems (95 % intervals)\n",
               found.points_used) +
           law("(tau/dt)^2 = A + B beta (tau/dt)", found.damped_oscillator) +
           law("dt = tau/(a + b beta)   (rule: 1.1, 2.9)", found.rule_form);
}

/// Largest of |error| over the stems; NaN if none is known.
double largest(const study::TimestepSummary& summary, std::size_t k,
               double study::StepResult::*member) {
    double found = std::nan("");
    for (const study::TimestepStem& stem : summary.stems)
        found = std::fmax(found, std::abs(stem.steps[k].*member));
    return found;
}

std::string errors(const study::TimestepSummary& summary) {
    if (summary.options.fractions.empty())
        return {};
    std::string text = fmt::format(
        "\nLargest relative error over the stems against the value extrapolated to step zero\n\n"
        "  {:>8} {:>8} {:>9} {:>11} {:>11}\n",
        "dt/limit", "fitted", "unstable", "b1", "b2");
    for (std::size_t k = 0; k < summary.options.fractions.size(); ++k) {
        text +=
            fmt::format("  {:>8.4g} {:>8} {:>9} {:>11.2e} {:>11.2e}\n",
                        summary.options.fractions[k], summary.count(k, study::StepOutcome::Fitted),
                        summary.count(k, study::StepOutcome::Unstable),
                        largest(summary, k, &study::StepResult::decay_error),
                        largest(summary, k, &study::StepResult::frequency_error));
    }
    return text;
}

} // namespace

std::string regression_table(const study::StudySummary& summary) {
    const std::string window =
        summary.reduce.window ? fmt::format("{:g} s", *summary.reduce.window) : "the whole record";
    std::string text =
        fmt::format("Eq. 1 fitted to the tip over {}, b0 {}; b1 per cycle, b2 in Hz; law {}\n\n",
                    window, summary.reduce.is_amplitude_free ? "free" : "fixed", summary.law);
    const bool is_published = summary.is_published;
    text += law("sqrt(Y)", "b2", is_published ? "574.3 b2 + 91.4 (Eq. 12; Y in Pa)" : "",
                summary.regression.sqrt_youngs_modulus);
    text += law("beta", "b1", is_published ? "-261.4 b1 + 2.5 (Eq. 13)" : "",
                summary.regression.bond_damping);
    if (summary.replicates)
        text += replicate_table(*summary.replicates, summary.failed.size());
    return text + failed_points_text(summary);
}

std::string timestep_table(const study::TimestepSummary& summary) {
    return limits(summary) + laws(summary.regression) + errors(summary) +
           failed_points_text(summary);
}

} // namespace culm::present
