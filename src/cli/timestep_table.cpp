// SPDX-License-Identifier: BSD-3-Clause
#include "cli/timestep_table.hpp"

#include "cli/failed_points.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/core.h>

namespace culm::cli {
namespace {

/// Stems that are listed on the screen; limits.csv has them all.
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
        text +=
            fmt::format("  … and {} more, see limits.csv\n", summary.stems.size() - listed_stems);
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
           law("dt = tau/(a + b beta)   (rule: 1.1, 2.9)", found.rule_form) +
           law("ln dt = ln_c + p ln Y + q ln beta", found.power_law);
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
        "  {:>8} {:>8} {:>9} {:>11} {:>11} {:>11} {:>11}\n",
        "dt/limit", "fitted", "unstable", "b1", "b1 linear", "b2", "b2 linear");
    for (std::size_t k = 0; k < summary.options.fractions.size(); ++k) {
        const auto count = [&](study::StepOutcome outcome) {
            return std::ranges::count_if(summary.stems, [&](const study::TimestepStem& stem) {
                return stem.steps[k].outcome == outcome;
            });
        };
        text += fmt::format("  {:>8.4g} {:>8} {:>9} {:>11.2e} {:>11.2e} {:>11.2e} {:>11.2e}\n",
                            summary.options.fractions[k], count(study::StepOutcome::Fitted),
                            count(study::StepOutcome::Unstable),
                            largest(summary, k, &study::StepResult::decay_error),
                            largest(summary, k, &study::StepResult::predicted_decay_error),
                            largest(summary, k, &study::StepResult::frequency_error),
                            largest(summary, k, &study::StepResult::predicted_frequency_error));
    }
    return text;
}

} // namespace

std::string timestep_table(const study::TimestepSummary& summary) {
    return limits(summary) + laws(summary.regression) + errors(summary) +
           failed_points_text(summary.failed, summary.points);
}

} // namespace culm::cli
