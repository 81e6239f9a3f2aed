// SPDX-License-Identifier: BSD-3-Clause
#include "cli/regression_table.hpp"

#include "cli/failed_points.hpp"
#include "cli/replicate_table.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/core.h>

namespace culm::cli {
namespace {

std::string law(const char* response, const char* predictor, const char* published,
                const reduce::RegressionOutcome& outcome) {
    if (!outcome.regression)
        return fmt::format("{:<10} no regression: {}\n", response, outcome.reason);
    const reduce::ResponseRegression& found = *outcome.regression;
    const auto& slope = found.single.slope;
    const auto& intercept = found.single.intercept;
    std::string text = fmt::format(
        "{} = {:.2f} {} {} {:.2f}      adjusted R² {:.5f}, {} points\n"
        "    published:          {}\n"
        "    95 % intervals:     slope {:.2f} … {:.2f}, intercept {:.2f} … {:.2f}\n",
        response, slope.value, predictor, intercept.value < 0 ? "-" : "+",
        std::abs(intercept.value), found.single.regression.adjusted_r_squared, found.points,
        published, slope.lower, slope.upper, intercept.lower, intercept.upper);
    double largest = 0.0;
    for (const double residual : found.single.residuals.percent)
        largest = std::max(largest, std::abs(residual));
    text +=
        fmt::format("    largest residual:   {:.2f} % of the largest observed value\n", largest);
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

} // namespace

std::string regression_table(const study::StudySummary& summary) {
    const std::string window =
        summary.reduce.window ? fmt::format("{:g} s", *summary.reduce.window) : "the whole record";
    std::string text =
        fmt::format("Eq. 1 fitted to the tip over {}, b0 {}; b1 per cycle, b2 in Hz\n\n", window,
                    summary.reduce.is_amplitude_free ? "free" : "fixed");
    text += law("sqrt(Y)", "b2", "574.3 b2 + 91.4 (Eq. 12; Y in Pa)",
                summary.regression.sqrt_youngs_modulus);
    text += law("beta", "b1", "-261.4 b1 + 2.5 (Eq. 13)", summary.regression.bond_damping);
    if (summary.replicates)
        text += replicate_table(*summary.replicates);
    return text + failed_points_text(summary.failed, summary.points);
}

} // namespace culm::cli
