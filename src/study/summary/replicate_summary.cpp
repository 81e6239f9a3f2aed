// SPDX-License-Identifier: BSD-3-Clause
#include "core/error.hpp"
#include "reduce/variance_shares.hpp"
#include "study/execute/plan.hpp"
#include "study/summary/summary.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <fmt/ranges.h>

namespace culm::study {
namespace {

using Eigen::Index;

bool is_logarithmic(const Factor& factor) {
    const auto* d = std::get_if<Distribution>(&factor.values);
    return d != nullptr &&
           (d->kind() == DistributionKind::Lognormal || d->kind() == DistributionKind::LogUniform);
}

/// The variable of the regression.
double germ(const Factor& factor, double value) {
    return is_logarithmic(factor) ? std::log(value) : value;
}

/// One column for each factor of the group.
Eigen::MatrixXd rows_of_design(const Study& study, const std::vector<std::size_t>& factors,
                               std::span<const std::int64_t> points) {
    Eigen::MatrixXd rows(std::ssize(points), std::ssize(factors));
    for (std::size_t row = 0; row < points.size(); ++row)
        for (std::size_t k = 0; k < factors.size(); ++k)
            rows(static_cast<Index>(row), static_cast<Index>(k)) =
                germ(study.config.factors[factors[k]], study.design.row(points[row])[factors[k]]);
    return rows;
}

/// Indices in StudyConfig::factors, group by group in the order of the first of each: columns whose
/// rows stay together depend on each other.
std::vector<std::vector<std::size_t>> dependent_factors(const std::vector<Factor>& factors) {
    std::vector<std::vector<std::size_t>> groups;
    for (std::size_t k = 0; k < factors.size(); ++k) {
        const auto group = std::ranges::find_if(groups, [&](const auto& of) {
            return factors[of.front()].coordinate() == factors[k].coordinate();
        });
        if (group == groups.end())
            groups.push_back({k});
        else
            group->push_back(k);
    }
    return groups;
}

std::vector<double> finite(std::span<const double> values) {
    std::vector<double> kept;
    std::ranges::copy_if(values, std::back_inserter(kept),
                         [](double value) { return std::isfinite(value); });
    return kept;
}

reduce::VarianceComponents components_of(const Study& study, std::span<const double> values) {
    const Design& design = study.design;
    // In a Latin hypercube or a Sobol sequence without replicates every design point is a stem of
    // one population; elsewhere stems are compared with those of their point.
    const bool is_one_population =
        study.config.design.replicates == 1 && study.config.design.is_sampled();
    std::vector<reduce::StemTests> stems;
    for (std::int64_t point = 0; point < design.point_count(); point += design.tests) {
        const auto tests = finite(values.subspan(static_cast<std::size_t>(point),
                                                 static_cast<std::size_t>(design.tests)));
        if (!tests.empty())
            stems.push_back(
                {is_one_population ? 0 : static_cast<std::size_t>(point / design.replicates),
                 tests});
    }
    return reduce::variance_components(stems);
}

/// Shares of both responses, or the reason why there are none.
void add_variance_shares(const Study& study, std::span<const double> decay_per_cycle,
                         std::span<const double> frequency, ReplicateSummary& summary) {
    std::vector<std::int64_t> points;
    for (std::size_t point = 0; point < frequency.size(); ++point)
        if (std::isfinite(frequency[point]) && std::isfinite(decay_per_cycle[point]))
            points.push_back(static_cast<std::int64_t>(point));
    std::vector<Eigen::MatrixXd> inputs;
    for (const auto& factors : dependent_factors(study.config.factors)) {
        inputs.push_back(rows_of_design(study, factors, points));
        std::vector<std::string> keys;
        for (const std::size_t factor : factors)
            keys.emplace_back(study.config.factors[factor].parameter->key);
        summary.groups.push_back({fmt::format("{}", fmt::join(keys, ", ")), keys});
    }
    const auto shares_of = [&](std::span<const double> values) {
        Eigen::MatrixXd response(std::ssize(points), 1);
        for (std::size_t row = 0; row < points.size(); ++row)
            response(static_cast<Index>(row), 0) = values[static_cast<std::size_t>(points[row])];
        return reduce::variance_shares(inputs, std::move(response));
    };
    try {
        summary.responses[0].variance_shares = shares_of(decay_per_cycle);
        summary.responses[1].variance_shares = shares_of(frequency);
    } catch (const core::NumericalError& error) {
        summary.no_shares_reason = error.what();
    }
}

} // namespace

std::optional<ReplicateSummary> summarise_replicates(const Study& study,
                                                     std::span<const double> decay_per_cycle,
                                                     std::span<const double> frequency) {
    if (study.config.factors.empty())
        return std::nullopt;
    ReplicateSummary summary;
    summary.has_distributions = std::ranges::any_of(study.config.factors, &Factor::is_redrawn);
    const auto add = [&](const char* name, std::span<const double> values) {
        summary.responses.push_back({name, reduce::summarise(finite(values)), {}, {}});
        if (study.design.tests > 1)
            summary.responses.back().components = components_of(study, values);
    };
    add("decay_per_cycle", decay_per_cycle);
    add("frequency", frequency);
    add_variance_shares(study, decay_per_cycle, frequency, summary);
    return summary;
}

} // namespace culm::study
