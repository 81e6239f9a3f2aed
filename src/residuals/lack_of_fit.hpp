// SPDX-License-Identifier: BSD-3-Clause
// Tests whether the residuals of a fitted chain are noise or physics is missing.
#pragma once

#include "residuals/swing.hpp"

#include <string>
#include <vector>

namespace culm::residuals {

/// One test; p is the probability of residuals at least as bad if nothing is missing.
struct LackOfFitTest {
    std::string name; ///< "size", "correlation at h = 133 mm", "correlation of the swing", …
    double p_value = 1.0;
    double adjusted_p_value = 1.0; ///< for the number of tests (Holm)
};

template <class To>
void describe(To& to, const LackOfFitTest& test) {
    to("name", test.name);
    to("p_value", test.p_value);
    to("adjusted_p_value", test.adjusted_p_value);
}

struct LackOfFit {
    std::vector<LackOfFitTest> tests; ///< not adjusted yet
    double effective_degrees_of_freedom = 0.0;
};

/// * "size": χ² against the noise, if that is known, with the effective degrees of freedom of the
///   residuals' own correlation.
/// * "correlation at h = … mm": Ljung & Box's test in every row, lags over a period.
/// * "correlation of the swing", "signs of the swing": Ljung & Box's and the runs test of the rows'
///   common part, their mean weighted with the shape of the held stem. A misfit of the first mode
///   is larger there by the square root of the number of rows.
/// * "correlation of all rows": Fisher's combination of the rows' p-values (weak correlation
///   everywhere).
/// * "likeness of the rows": Σ n r², r the correlation of two rows' residuals at the same times,
///   over all pairs; χ². A misfit of the shape moves the rows together; noise does not.
/// * "balance of the rows": means of the rows over all frames, χ² against their scatter; large if
///   the shape or the position of rest is wrong.
[[nodiscard]] LackOfFit test_lack_of_fit(const fit::RecordingFit& fit, const Swing& swing);

} // namespace culm::residuals
