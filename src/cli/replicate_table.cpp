// SPDX-License-Identifier: BSD-3-Clause
#include "cli/replicate_table.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/core.h>

namespace culm::cli {
namespace {

/// As the paper calls it.
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
                       short_name(response), root_with_bounds(c.between, c.between_interval),
                       root_with_bounds(c.within, c.within_interval),
                       percent_with_bounds({c.intraclass_correlation, c.intraclass_interval}));
}

std::string sensitivity_lines(const study::ResponseSpread& response) {
    const reduce::Sensitivity& s = *response.sensitivity;
    std::string text = fmt::format(
        "    {:<14} polynomials of degree {} predict {:.2f} % of the variance of points left out; "
        "interactions {:.1f} %\n",
        short_name(response), s.degree, 100.0 * s.predicted_share, 100.0 * s.interactions);
    if (s.degree == 0)
        return text;
    std::size_t width = 0;
    for (const reduce::GroupSensitivity& group : s.groups)
        width = std::max(width, group.name.size());
    for (const reduce::GroupSensitivity& group : s.groups)
        text +=
            fmt::format("        {:<{}}  alone {}, with interactions {}\n", group.name, width,
                        percent_with_bounds(group.first_order), percent_with_bounds(group.total));
    return text;
}

} // namespace

std::string replicate_table(const study::ReplicateSummary& summary) {
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
    text += "\nWhere the spread comes from (Sobol indices by polynomial chaos)\n";
    if (!summary.no_sensitivity_reason.empty())
        return text + fmt::format("    not known: {}\n", summary.no_sensitivity_reason);
    for (const study::ResponseSpread& response : summary.responses)
        if (response.sensitivity)
            text += sensitivity_lines(response);
    for (const study::FactorGroup& group : summary.groups)
        if (group.factors.size() > 1)
            text += fmt::format("    {} depend on each other: their index is of all of them "
                                "together\n",
                                group.name);
    return text;
}

} // namespace culm::cli
