// SPDX-License-Identifier: BSD-3-Clause
#include "study/design.hpp"

#include "study/design_sampling.hpp"
#include "study/random.hpp"

#include <utility>
#include <variant>

namespace culm::study {

namespace {

/// Writes one column of the design, from the value at each (design point, replicate).
template <class ValueAt>
void fill_column(Design& design, std::size_t column, ValueAt value_at) {
    const std::size_t width = design.factors.size();
    std::size_t row = 0;
    for (std::int64_t point = 0; point < design.design_points; ++point)
        for (std::int64_t replicate = 0; replicate < design.replicates; ++replicate, ++row)
            design.values[row * width + column] = value_at(point, replicate);
}

/// A distribution in a factorial or a list: an independent draw at every point and replicate.
void fill_with_draws(const StudyConfig& config, Design& design, std::size_t column) {
    const Factor& factor = design.factors[column];
    const auto& distribution = std::get<Distribution>(factor.values);
    RandomKey key{config.seed, RandomPurpose::Draw, factor_id(factor.parameter->key), 0, 0};
    fill_column(design, column, [&](std::int64_t point, std::int64_t replicate) {
        key.point = static_cast<std::uint64_t>(point);
        key.replicate = static_cast<std::uint64_t>(replicate);
        return distribution.quantile(random_uniform(key));
    });
}

void fill_factorial(const StudyConfig& config, Design& design) {
    std::int64_t period = 1; // design points after which the column's level changes
    for (std::size_t column = design.factors.size(); column-- > 0;) {
        const auto* levels = std::get_if<Levels>(&design.factors[column].values);
        if (levels == nullptr) {
            fill_with_draws(config, design, column);
            continue;
        }
        const auto count = static_cast<std::int64_t>(levels->size());
        fill_column(design, column, [&](std::int64_t point, std::int64_t) {
            return (*levels)[static_cast<std::size_t>(point / period % count)];
        });
        period *= count;
    }
}

void fill_list(const StudyConfig& config, Design& design) {
    for (std::size_t column = 0; column < design.factors.size(); ++column) {
        if (const auto* levels = std::get_if<Levels>(&design.factors[column].values))
            fill_column(design, column, [&](std::int64_t point, std::int64_t) {
                return (*levels)[static_cast<std::size_t>(point)];
            });
        else
            fill_with_draws(config, design, column);
    }
}

void fill_latin_hypercube(const StudyConfig& config, Design& design) {
    const std::size_t width = design.factors.size();
    for (std::size_t column = 0; column < width; ++column) {
        const Factor& factor = design.factors[column];
        SampleKey key{config.seed, factor.parameter->key, 0};
        std::vector<double> u;
        for (std::int64_t replicate = 0; replicate < design.replicates; ++replicate) {
            key.replicate = replicate;
            if (replicate == 0 || factor.is_redrawn)
                u = latin_hypercube_coordinate(key, design.design_points);
            for (std::size_t point = 0; point < u.size(); ++point) {
                const std::size_t row = point * static_cast<std::size_t>(design.replicates) +
                                        static_cast<std::size_t>(replicate);
                design.values[row * width + column] = factor.quantile(u[point]);
            }
        }
    }
}

void fill_sobol(const StudyConfig& config, Design& design) {
    const std::size_t width = design.factors.size();
    const std::vector<double> points = sobol_points(design.design_points, width);
    for (std::size_t column = 0; column < width; ++column) {
        const Factor& factor = design.factors[column];
        SampleKey key{config.seed, factor.parameter->key, 0};
        fill_column(design, column, [&](std::int64_t point, std::int64_t replicate) {
            const double u = points[static_cast<std::size_t>(point) * width + column];
            key.replicate = replicate;
            return factor.quantile(replicate > 0 && factor.is_redrawn ? rotated(u, key) : u);
        });
    }
}

std::int64_t design_point_count(const StudyConfig& config) {
    if (config.design.type != DesignType::Factorial)
        return config.design.points;
    std::int64_t count = 1;
    for (const Factor& factor : config.factors)
        if (const auto* levels = std::get_if<Levels>(&factor.values))
            count *= static_cast<std::int64_t>(levels->size());
    return count;
}

} // namespace

Design make_design(const StudyConfig& config) {
    Design design{config.factors, design_point_count(config), config.design.replicates, {}};
    design.values.resize(static_cast<std::size_t>(design.point_count()) * design.factors.size());
    switch (config.design.type) {
    case DesignType::Factorial:
        fill_factorial(config, design);
        break;
    case DesignType::LatinHypercube:
        fill_latin_hypercube(config, design);
        break;
    case DesignType::Sobol:
        fill_sobol(config, design);
        break;
    case DesignType::List:
        fill_list(config, design);
        break;
    }
    return design;
}

run::CaseSpec case_of_point(const StudyConfig& config, const Design& design, std::int64_t point) {
    ParameterValues values = config.given;
    const std::span<const double> row = design.row(point);
    for (std::size_t column = 0; column < row.size(); ++column)
        values.set(*design.factors[column].parameter, row[column]);
    run::CaseSpec spec = config.base;
    spec.point = point;
    values.apply_to(spec);
    return spec;
}

} // namespace culm::study
