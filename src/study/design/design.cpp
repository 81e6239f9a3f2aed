// SPDX-License-Identifier: BSD-3-Clause
#include "study/design/design.hpp"

#include "study/config/study_config.hpp"
#include "study/design/sampling.hpp"

#include <algorithm>
#include <cstdint>
#include <string>
#include <variant>
#include <vector>

namespace culm::study {
namespace {

/// One coordinate of the unit cube; factors whose rows stay together share one.
struct UnitSample {
    std::string name;
    std::int64_t draws = 1; ///< for each design point: one, one for each stem, or for each test
    std::vector<double> u;  ///< (design points, draws), in (0, 1)
};

struct UnitSamples {
    std::vector<UnitSample> samples;
    /// The sample of each factor; none if its levels are enumerated.
    std::vector<std::size_t> sample_of_factor;
    static constexpr std::size_t none = static_cast<std::size_t>(-1);
};

std::int64_t draws_of(const Factor& factor, const DesignOptions& design) {
    if (!factor.is_redrawn)
        return 1;
    return factor.is_per_test ? design.replicates * design.tests : design.replicates;
}

UnitSamples without_values(const StudyConfig& config) {
    UnitSamples result;
    for (const Factor& factor : config.factors) {
        // A factorial and a list enumerate levels; hypercubes and sequences spread over them as
        // over a distribution, so that levels need a coordinate there too.
        if (!config.design.is_sampled() && std::holds_alternative<Levels>(factor.values)) {
            result.sample_of_factor.push_back(UnitSamples::none);
            continue;
        }
        // Columns whose rows stay together share a coordinate, and therefore the drawn row.
        const auto known =
            std::ranges::find(result.samples, factor.coordinate(), &UnitSample::name);
        result.sample_of_factor.push_back(static_cast<std::size_t>(known - result.samples.begin()));
        if (known == result.samples.end())
            result.samples.push_back(
                {std::string(factor.coordinate()), draws_of(factor, config.design), {}});
    }
    return result;
}

void draw_at_random(const StudyConfig& config, std::int64_t points, UnitSample& sample) {
    // Numbers depend only on the counter: point 7 does not depend on the order of drawing or on the
    // number of points.
    RandomKey key{config.seed, RandomPurpose::Draw, factor_id(sample.name), 0, 0};
    auto u = sample.u.begin();
    for (std::int64_t point = 0; point < points; ++point)
        for (std::int64_t draw = 0; draw < sample.draws; ++draw) {
            key.point = static_cast<std::uint64_t>(point);
            key.replicate = static_cast<std::uint64_t>(draw);
            *u++ = random_uniform(key);
        }
}

/// One hypercube over the design points for each draw.
void draw_hypercubes(const StudyConfig& config, std::int64_t points,
                     std::vector<UnitSample>& samples) {
    for (UnitSample& sample : samples)
        for (std::int64_t draw = 0; draw < sample.draws; ++draw) {
            const SampleKey key{config.seed, sample.name, draw};
            const auto u = places_in_strata(key, latin_hypercube_strata(key, points));
            for (std::size_t point = 0; point < u.size(); ++point)
                sample.u[point * static_cast<std::size_t>(sample.draws) +
                         static_cast<std::size_t>(draw)] = u[point];
        }
}

/// An unscrambled sequence starts after the origin, and draws after the first are rotated. A
/// scrambled sequence includes the origin, and each draw has its own scrambling.
void draw_sequence(const StudyConfig& config, std::int64_t points,
                   std::vector<UnitSample>& samples) {
    const Scrambling scrambling = config.design.scrambling;
    const std::int64_t first = scrambling == Scrambling::None ? 1 : 0;
    const std::size_t width = samples.size();
    const std::vector<std::uint64_t> digits = sobol_digits(points + first, width);
    for (std::size_t k = 0; k < width; ++k) {
        UnitSample& sample = samples[k];
        for (std::int64_t draw = 0; draw < sample.draws; ++draw) {
            const SampleKey key{config.seed, sample.name, draw};
            const DigitScrambler scrambler(scrambling, key, points);
            for (std::int64_t point = 0; point < points; ++point) {
                const std::uint64_t raw =
                    digits[static_cast<std::size_t>(point + first) * width + k];
                double u = open_unit_interval(scrambler(raw));
                if (scrambling == Scrambling::None && draw > 0)
                    u = rotated(u, key);
                sample.u[static_cast<std::size_t>(point * sample.draws + draw)] = u;
            }
        }
    }
}

/// The samples of a study with `design_points` points. They depend only on the study
/// (design.hpp describes them).
UnitSamples draw_unit_samples(const StudyConfig& config, std::int64_t design_points) {
    UnitSamples all = without_values(config);
    for (UnitSample& sample : all.samples)
        sample.u.resize(static_cast<std::size_t>(design_points * sample.draws));
    if (config.design.type == DesignType::LatinHypercube)
        draw_hypercubes(config, design_points, all.samples);
    else if (config.design.type == DesignType::Sobol)
        draw_sequence(config, design_points, all.samples);
    else
        for (UnitSample& sample : all.samples)
            draw_at_random(config, design_points, sample);
    return all;
}

/// Writes one column of the design, from the value at each (design point, replicate).
template <class ValueAt>
void fill_column(Design& design, std::size_t column, ValueAt value_at) {
    const std::size_t width = design.factors.size();
    std::size_t row = 0;
    for (std::int64_t point = 0; point < design.design_points; ++point)
        for (std::int64_t replicate = 0; replicate < design.replicates; ++replicate, ++row)
            design.values[row * width + column] = value_at(point, replicate);
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
        const WithinStemScatter& scatter = *factor.within_stem;
        return Distribution::normal(value, scatter.sd, scatter.min, scatter.max)
            .quantile(random_uniform(key));
    });
}

/// Fills the columns of enumerated levels: all combinations, or the points of a list.
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
        // The last factor varies fastest. The columns of a list run in parallel, with a period of
        // one.
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
