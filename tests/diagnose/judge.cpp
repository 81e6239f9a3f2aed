// SPDX-License-Identifier: BSD-3-Clause
#include "diagnose/judge.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace culm::tests {
namespace {

fit::Fit fit(double chi_squared, std::size_t effects) {
    fit::Fit out;
    out.status = fit::FitStatus::Fitted;
    out.names.assign(1 + effects, "name");
    out.parameters.resize(4 + effects);
    out.readings = 4000;
    out.effective_readings = 4000.0;
    out.chi_squared = chi_squared;
    out.reduced_chi_squared = chi_squared / 4000.0;
    out.rmse = 1e-4 * std::sqrt(out.reduced_chi_squared);
    out.misfits = {{out.readings, chi_squared, out.rmse, true}};
    return out;
}

std::string objection(const fit::Fit& smaller, const fit::Fit& larger) {
    const std::vector<fit::Fit> both{smaller, larger};
    const diagnose::Criterion by = diagnose::criterion(both);
    return diagnose::in_words(diagnose::judge(
        {.smaller = smaller, .larger = larger, .criterion = by, .added = {}, .tried = 18}));
}

TEST(Judge, IsAGainThatNoiseCouldMake) {
    EXPECT_EQ(objection(fit(4008.0, 0), fit(4000.0, 1)), "BIC rises by 0.3");
    EXPECT_EQ(objection(fit(4060.0, 0), fit(4000.0, 1)), "BIC falls by 52");
}

TEST(Judge, StatesByHowMuchTheCriterionFalls) {
    EXPECT_EQ(objection(fit(600000.0, 0), fit(400000.0, 1)), "BIC falls by 1992");
}

/// Two recordings: one that states its noise with this χ², one that does not with this rms (m).
fit::Fit fit_of_two(double chi_squared, double rmse, bool is_known_first) {
    fit::Fit out = fit(chi_squared + 4000.0, 0);
    const fit::RecordingMisfit known{2000, chi_squared, 1e-4 * std::sqrt(chi_squared / 2000.0),
                                     true};
    const fit::RecordingMisfit unknown{2000, 2000.0, rmse, false};
    out.misfits = is_known_first ? std::vector{known, unknown} : std::vector{unknown, known};
    out.rmse = std::hypot(known.rmse, rmse) / std::sqrt(2.0);
    return out;
}

TEST(Criterion, DoesNotDependOnWhichRecordingComesFirst) {
    const auto gain = [](const fit::Fit& smaller, const fit::Fit& larger) {
        const std::vector<fit::Fit> both{smaller, larger};
        const diagnose::Criterion by = diagnose::criterion(both);
        return diagnose::bic(smaller, by) - diagnose::bic(larger, by);
    };
    for (const bool is_known_first : {true, false}) {
        // A fall of χ² where the noise is stated, and nothing elsewhere.
        EXPECT_NEAR(gain(fit_of_two(2100.0, 1e-4, is_known_first),
                         fit_of_two(2000.0, 1e-4, is_known_first)),
                    100.0 / 1.5, 1e-6);
        // A fall by 10 % of the mean square where only the residuals give the noise.
        EXPECT_NEAR(gain(fit_of_two(2000.0, 1e-4 * std::sqrt(1.1), is_known_first),
                         fit_of_two(2000.0, 1e-4, is_known_first)),
                    200.0, 1e-6);
    }
}

} // namespace
} // namespace culm::tests
