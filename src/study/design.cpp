// SPDX-License-Identifier: BSD-3-Clause
#include "study/design.hpp"

#include "study/random.hpp"
#include "study/unit_samples.hpp"

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

/// The scatter of a test about its stem's value.
double scattered(double value, const WithinStemScatter& scatter, const RandomKey& key) {
    return Distribution::normal(value, scatter.sd, scatter.min, scatter.max)
        .quantile(random_uniform(key));
}

void fill_from_sample(const StudyConfig& config, Design& design, std::size_t column,
                      const UnitSample& sample) {
    const Factor& factor = design.factors[column];
    const std::int64_t repeats = design.replicates / sample.draws;
    RandomKey key{config.seed, RandomPurpose::WithinStem, factor_id(factor.parameter->key), 0, 0};
    fill_column(design, column, [&](std::int64_t point, std::int64_t replicate) {
        const std::int64_t place = point * sample.draws + replicate / repeats;
        const double value = factor.quantile(sample.u[static_cast<std::size_t>(place)]);
        if (!factor.within_stem)
            return value;
        key.point = static_cast<std::uint64_t>(point);
        key.replicate = static_cast<std::uint64_t>(replicate);
        return scattered(value, *factor.within_stem, key);
    });
}

/// Levels that are taken one by one: all combinations, or the points of a list.
void fill_levels(const StudyConfig& config, Design& design, const UnitSamples& samples) {
    std::int64_t period = 1; // design points after which the column's level changes
    for (std::size_t column = design.factors.size(); column-- > 0;) {
        if (samples.sample_of_factor[column] != UnitSamples::none)
            continue;
        const auto& levels = std::get<Levels>(design.factors[column].values);
        const auto count = static_cast<std::int64_t>(levels.size());
        fill_column(design, column, [&](std::int64_t point, std::int64_t) {
            return levels[static_cast<std::size_t>(point / period % count)];
        });
        if (config.design.type == DesignType::Factorial)
            period *= count;
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

std::int64_t point_count_of(const StudyConfig& config) {
    return design_point_count(config) * config.design.replicates * config.design.tests;
}

Design make_design(const StudyConfig& config) {
    const std::int64_t replicates = config.design.replicates * config.design.tests;
    Design design{config.factors, design_point_count(config), replicates, config.design.tests, {}};
    design.values.resize(static_cast<std::size_t>(design.point_count()) * design.factors.size());
    const UnitSamples samples = draw_unit_samples(config, design.design_points);
    fill_levels(config, design, samples);
    for (std::size_t column = 0; column < design.factors.size(); ++column)
        if (const std::size_t sample = samples.sample_of_factor[column];
            sample != UnitSamples::none)
            fill_from_sample(config, design, column, samples.samples[sample]);
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
