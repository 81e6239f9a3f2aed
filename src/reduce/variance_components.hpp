// SPDX-License-Identifier: BSD-3-Clause
// Components of the variance: between stems, and between tests of one stem.
#pragma once

#include "reduce/population_statistics.hpp"

#include <cstddef>
#include <span>
#include <string>
#include <vector>

namespace culm::reduce {

/// The tests of one stem.
struct StemTests {
    std::size_t stratum = 0;    ///< stems are compared with stems of the same stratum only
    std::vector<double> values; ///< at least one, all finite
};

/// The one-way random-effects model y_ij = μ + a_i + e_ij: Var(a) between stems, Var(e) between
/// tests of one stem. Where strata differ, each has its own μ. Quantities for which the sample is
/// too small are NaN.
struct VarianceComponents {
    std::size_t stems = 0;
    std::size_t tests = 0;
    double tests_per_stem = 0.0; ///< harmonic mean
    double between = 0.0;        ///< variance; negative estimates are set to zero
    Bounds between_interval;
    double within = 0.0; ///< variance
    Bounds within_interval;
    double intraclass_correlation = 0.0; ///< between / (between + within)
    Bounds intraclass_interval;
    double f_statistic = 0.0; ///< of the test that stems do not differ
    double p_value = 1.0;
    std::size_t between_degrees_of_freedom = 0;
    std::size_t within_degrees_of_freedom = 0;
    std::string reason; ///< one sentence if `between` or `within` is not identifiable
};

/// Analysis of variance with unweighted means of the stems (Thomas & Hultquist 1978); for equal
/// numbers of tests it is the ordinary one. 95 % intervals: χ² for `within`, the modified
/// large-sample method of Ting et al. (1990) for `between`, F for the intraclass correlation; all
/// assume normal effects.
[[nodiscard]] VarianceComponents variance_components(std::span<const StemTests> stems);

} // namespace culm::reduce
