// SPDX-License-Identifier: BSD-3-Clause
// Tail probabilities and quantiles for the intervals and tests of this layer.
#pragma once

#include <cstddef>

namespace culm::reduce {

/// Two-sided 95 % quantile of the standard normal distribution.
inline constexpr double normal_quantile_95 = 1.959964;

/// Coverage of every interval that this layer reports.
inline constexpr double confidence_level = 0.95;

/// Half-width of the two-sided interval of coverage `confidence_level`, in standard errors: the
/// quantile of Student's t distribution. Throws std::domain_error unless degrees_of_freedom > 0.
[[nodiscard]] double student_t_factor(std::size_t degrees_of_freedom);

/// P(|T| >= |t|) for Student's t distribution; 0 for an infinite t.
[[nodiscard]] double student_t_p_value(double t, std::size_t degrees_of_freedom);

/// P(X >= f) for Fisher's F distribution with the degrees of freedom of the numerator and of the
/// denominator; 0 for an infinite f, 1 for f <= 0.
[[nodiscard]] double fisher_f_p_value(double f, std::size_t numerator, std::size_t denominator);

} // namespace culm::reduce
