// SPDX-License-Identifier: BSD-3-Clause
#include "study/factor_groups.hpp"

#include "study/design_sampling.hpp"

#include <algorithm>
#include <cmath>

#include <boost/math/quadrature/gauss.hpp>

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

} // namespace

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

reduce::InputGroup input_group(const Study& study, const std::vector<std::size_t>& factors,
                               std::span<const std::int64_t> points) {
    constexpr std::size_t most_rows = 10'000;
    const StudyConfig& config = study.config;
    reduce::InputGroup group;
    for (const std::size_t factor : factors) {
        if (!group.name.empty())
            group.name += ", ";
        group.name += config.factors[factor].parameter->key;
    }
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

} // namespace culm::study
