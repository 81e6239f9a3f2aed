// SPDX-License-Identifier: BSD-3-Clause
// The points of a study: which values the factors take, and the case of each point.
#pragma once

#include "run/case_spec.hpp"
#include "study/config/study_config.hpp"

#include <cstdint>
#include <span>
#include <vector>

namespace culm::study {

/// Points are numbered design_point · replicates + replicate, replicates stem · tests + test; the
/// numbers do not depend on ranks or on the order of computation. A point's values are a pure
/// function of the config.
struct Design {
    std::vector<Factor> factors;    ///< the columns, in the order of the config
    std::int64_t design_points = 0; ///< without replicates
    std::int64_t replicates = 1;    ///< of each design point: stems · tests
    std::int64_t tests = 1;         ///< of each stem
    std::vector<double> values;     ///< (points, factors), row-major, SI

    [[nodiscard]] std::int64_t point_count() const { return design_points * replicates; }
    [[nodiscard]] std::span<const double> row(std::int64_t point) const {
        return std::span(values).subspan(static_cast<std::size_t>(point) * factors.size(),
                                         factors.size());
    }
};

/// Largest number of points that a study may have.
inline constexpr std::int64_t most_points = 100'000'000;

/// Points of a validated study, replicates included.
[[nodiscard]] std::int64_t point_count_of(const StudyConfig& config);

/// The design of a validated study.
///   - factorial: every combination of the levels; the first factor varies slowest, the last
///     fastest. Distributions are drawn for every (design point, replicate).
///   - latin_hypercube: each factor's N strata of equal probability hold one point each (McKay,
///     Beckman & Conover 1979), at a random position in the stratum. A replicate keeps lists and
///     ranges and spreads the distributions over a new hypercube.
///   - sobol: the Sobol sequence with the direction numbers of Joe & Kuo (2008), first dimension =
///     first factor, without its first element, the origin, where inverse distribution functions
///     may be infinite: the first points are (1/2, 1/2 …), (3/4, 1/4 …). Replicates after the first
///     rotate the distributions' coordinates modulo 1 (Cranley & Patterson 1976). With scrambling,
///     every replicate has its own scrambling, and the origin is included.
///   - list: the values of [[design.point]], in their order; distributions as in a factorial.
/// A factor is drawn once for each stem and kept in its tests, or drawn for each test; the scatter
/// within a stem is drawn for each test.
[[nodiscard]] Design make_design(const StudyConfig& config);

/// The case of one point, 0 <= point < design.point_count().
[[nodiscard]] run::CaseSpec case_of_point(const StudyConfig& config, const Design& design,
                                          std::int64_t point);

} // namespace culm::study
