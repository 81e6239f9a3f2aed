// SPDX-License-Identifier: BSD-3-Clause
#include "core/error.hpp"
#include "reduce/sensitivity.hpp"
#include "study/design/sampling.hpp"
#include "study/execute/plan.hpp"
#include "study/summary/summary.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <ranges>
#include <span>
#include <vector>

#include <boost/math/quadrature/gauss.hpp>
#include <fmt/ranges.h>

namespace culm::study {
namespace {

using Eigen::Index;

bool is_logarithmic(const Factor& factor) {
    const auto* d = std::get_if<Distribution>(&factor.values);
    return d != nullptr &&
           (d->kind() == DistributionKind::Lognormal || d->kind() == DistributionKind::LogUniform);
}

/// The variable whose polynomials are used.
double germ(const Factor& factor, double value) {
    return is_logarithmic(factor) ? std::log(value) : value;
}

bool is_dependent(const StudyConfig& config, std::size_t a, std::size_t b) {
    if (config.factors[a].coordinate() == config.factors[b].coordinate())
        return true;
    if (!config.correlation)
        return false;
    const auto& members = config.correlation->factors;
    const auto i = std::ranges::find(members, a);
    const auto j = std::ranges::find(members, b);
    return i != members.end() && j != members.end() &&
           config.correlation->rank.rank(static_cast<std::size_t>(i - members.begin()),
                                         static_cast<std::size_t>(j - members.begin())) != 0.0;
}

struct Nodes {
    std::vector<double> values;
    std::vector<double> weights;
};

/// Gauss's rule in u on panels that halve towards both ends, where inverse distribution functions
/// may be infinite.
Nodes quadrature_nodes(const Factor& factor) {
    using Rule = boost::math::quadrature::gauss<double, 10>;
    constexpr int panels = 40;
    Nodes nodes;
    for (int k = 1; k <= panels; ++k) {
        // Panel k and its mirror image have the probability 2^-(k+1) each. Forty of them leave
        // 10⁻¹² of it to the tails, where no draw of a study falls.
        const double width = std::ldexp(1.0, -k - 1);
        for (std::size_t n = 0; n < Rule::abscissa().size(); ++n)
            for (const double side : {-1.0, 1.0}) {
                const double u = width * (1.5 + 0.5 * side * Rule::abscissa()[n]);
                for (const double place : {u, 1.0 - u}) {
                    nodes.values.push_back(factor.quantile(place));
                    nodes.weights.push_back(0.5 * width * Rule::weights()[n]);
                }
            }
    }
    return nodes;
}

Nodes nodes_of(const Factor& factor) {
    const auto* distribution = std::get_if<Distribution>(&factor.values);
    if (distribution != nullptr && distribution->kind() != DistributionKind::Empirical)
        return quadrature_nodes(factor);
    Nodes nodes;
    if (distribution == nullptr)
        nodes.values = std::get<Levels>(factor.values);
    else
        nodes.values.assign(distribution->values().begin(), distribution->values().end());
    nodes.weights.assign(nodes.values.size(), 1.0);
    return nodes;
}

/// One column for each factor of the group.
Eigen::MatrixXd rows_of_table(const StudyConfig& config, const std::vector<std::size_t>& factors) {
    const auto& first = std::get<Distribution>(config.factors[factors.front()].values);
    Eigen::MatrixXd rows(static_cast<Index>(first.values().size()),
                         static_cast<Index>(factors.size()));
    for (std::size_t k = 0; k < factors.size(); ++k) {
        const auto& factor = config.factors[factors[k]];
        const auto values = std::get<Distribution>(factor.values).values();
        for (std::size_t row = 0; row < values.size(); ++row)
            rows(static_cast<Index>(row), static_cast<Index>(k)) = germ(factor, values[row]);
    }
    return rows;
}

Eigen::MatrixXd correlated_sample(const StudyConfig& config,
                                  const std::vector<std::size_t>& factors) {
    // 2¹³ − 1 points after the origin: with it a whole net, whose errors fall nearly as 1/n.
    constexpr std::int64_t count = 8191;
    const auto& members = config.correlation->factors;
    const std::vector<double> points = sobol_points(count, members.size());
    Eigen::MatrixXd sample(count, static_cast<Index>(factors.size()));
    for (Index row = 0; row < count; ++row) {
        std::vector<double> u(members.size());
        std::copy_n(points.begin() + static_cast<std::ptrdiff_t>(row * Index(u.size())), u.size(),
                    u.begin());
        config.correlation->rank.correlate(u);
        for (std::size_t k = 0; k < factors.size(); ++k) {
            const auto place = std::ranges::find(members, factors[k]) - members.begin();
            const Factor& factor = config.factors[factors[k]];
            sample(row, static_cast<Index>(k)) =
                germ(factor, factor.quantile(u[static_cast<std::size_t>(place)]));
        }
    }
    return sample;
}

Eigen::MatrixXd rows_of_design(const Study& study, const std::vector<std::size_t>& factors,
                               std::span<const std::int64_t> points, std::size_t stride) {
    Eigen::MatrixXd rows(static_cast<Index>((points.size() + stride - 1) / stride),
                         static_cast<Index>(factors.size()));
    for (Index row = 0; row < rows.rows(); ++row)
        for (std::size_t k = 0; k < factors.size(); ++k)
            rows(row, static_cast<Index>(k)) =
                germ(study.config.factors[factors[k]],
                     study.design.row(points[static_cast<std::size_t>(row) * stride])[factors[k]]);
    return rows;
}

/// Indices in StudyConfig::factors, group by group in the order of the first of each:
/// correlated factors belong together, and columns whose rows stay together.
std::vector<std::vector<std::size_t>> dependent_factors(const StudyConfig& config) {
    std::vector<std::vector<std::size_t>> groups;
    std::vector<bool> is_placed(config.factors.size(), false);
    for (std::size_t first = 0; first < config.factors.size(); ++first) {
        if (is_placed[first])
            continue;
        std::vector<std::size_t> group{first};
        is_placed[first] = true;
        for (std::size_t k = 0; k < group.size(); ++k) // the group grows meanwhile
            for (std::size_t other = 0; other < config.factors.size(); ++other)
                if (!is_placed[other] && is_dependent(config, group[k], other)) {
                    group.push_back(other);
                    is_placed[other] = true;
                }
        std::ranges::sort(group);
        groups.push_back(std::move(group));
    }
    return groups;
}

/// The group's values at these points and its distribution: levels with equal weights, rows of the
/// table, quadrature nodes of a single distribution, a Sobol sample of correlated ones, and
/// the design's own rows for factors that scatter within stems. Lognormal and log-uniform factors
/// enter as logarithms.
reduce::InputGroup input_group(const Study& study, const std::vector<std::size_t>& factors,
                               std::span<const std::int64_t> points) {
    constexpr std::size_t most_rows = 10'000;
    const StudyConfig& config = study.config;
    reduce::InputGroup group;
    const auto key_of = [&](std::size_t factor) { return config.factors[factor].parameter->key; };
    group.name = fmt::format("{}", fmt::join(factors | std::views::transform(key_of), ", "));
    group.values = rows_of_design(study, factors, points, 1);
    const bool scatters = std::ranges::any_of(
        factors, [&](std::size_t k) { return config.factors[k].within_stem.has_value(); });
    if (scatters) {
        group.nodes =
            rows_of_design(study, factors, points, (points.size() + most_rows - 1) / most_rows);
    } else if (factors.size() == 1) {
        const Factor& factor = config.factors[factors.front()];
        Nodes nodes = nodes_of(factor);
        for (double& value : nodes.values)
            value = germ(factor, value);
        group.nodes = Eigen::Map<Eigen::VectorXd>(nodes.values.data(), Index(nodes.values.size()));
        group.weights =
            Eigen::Map<Eigen::VectorXd>(nodes.weights.data(), Index(nodes.weights.size()));
        group.weights /= group.weights.sum();
        return group;
    } else if (config.factors[factors.front()].measured &&
               config.factors[factors.front()].measured->keeps_rows) {
        group.nodes = rows_of_table(config, factors);
    } else {
        group.nodes = correlated_sample(config, factors);
    }
    group.weights = Eigen::VectorXd::Constant(group.nodes.rows(),
                                              1.0 / static_cast<double>(group.nodes.rows()));
    return group;
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

/// Sensitivities of both responses, or the reason why there are none.
void add_sensitivities(const Study& study, std::span<const double> decay_per_cycle,
                       std::span<const double> frequency, ReplicateSummary& summary) {
    if (study.config.design.type == DesignType::List) {
        summary.no_sensitivity_reason = "the points of a list have no distribution";
        return;
    }
    std::vector<std::int64_t> points;
    for (std::size_t point = 0; point < frequency.size(); ++point)
        if (std::isfinite(frequency[point]) && std::isfinite(decay_per_cycle[point]))
            points.push_back(static_cast<std::int64_t>(point));
    Eigen::MatrixXd responses(static_cast<Eigen::Index>(points.size()), 2);
    for (Eigen::Index row = 0; row < responses.rows(); ++row) {
        const auto point = static_cast<std::size_t>(points[static_cast<std::size_t>(row)]);
        responses.row(row) << decay_per_cycle[point], frequency[point];
    }
    std::vector<reduce::InputGroup> groups;
    for (const auto& factors : dependent_factors(study.config)) {
        groups.push_back(input_group(study, factors, points));
        FactorGroup group{groups.back().name, {}};
        for (const std::size_t factor : factors)
            group.factors.emplace_back(study.config.factors[factor].parameter->key);
        summary.groups.push_back(std::move(group));
    }
    try {
        auto found = reduce::analyse_sensitivity(groups, responses);
        for (std::size_t k = 0; k < found.size(); ++k)
            summary.responses[k].sensitivity = std::move(found[k]);
    } catch (const core::NumericalError& error) {
        summary.no_sensitivity_reason = error.what();
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
    add_sensitivities(study, decay_per_cycle, frequency, summary);
    return summary;
}

} // namespace culm::study
