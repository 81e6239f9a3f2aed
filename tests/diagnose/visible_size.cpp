// SPDX-License-Identifier: BSD-3-Clause
// The size at which an effect is seen, against refits of recordings that contain just that much.
#include "diagnose/score/score_test.hpp"
#include "diagnosis_records.hpp"
#include "fit/model/prediction.hpp"
#include "support/parameter_ids.hpp"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

namespace culm::tests {
namespace {

/// What the published chain would have shown with the effect, without noise.
std::vector<fit::ObservedRecording> recording_with(const std::string& effect, const std::string& of,
                                                   double value, const fit::Fit& base,
                                                   std::vector<fit::ObservedRecording> recordings) {
    fit::StemModel model = fit::candidate_model(
        base.parts.front().model, physics::parse_effects(effect, {}), recordings.front());
    // The places where the score looks for them first and sees them best.
    const double near_the_clamp = 0.1 * model.spec.stem.free_length();
    for (const fit::FreeParameter& parameter : model.parameters) {
        if (to_string(parameter.access.id) == effect + "." + of)
            parameter.access.set(model.spec, value);
        if (to_string(parameter.access.id) == "local_defect.position_m")
            parameter.access.set(model.spec, near_the_clamp);
        if (to_string(parameter.access.id) == "out_of_plane.angle_deg")
            parameter.access.set(model.spec, 25.0);
    }
    recordings.front().deflections =
        fit::predict_readings(model, recordings.front().times).readings;
    return recordings;
}

double youngs_modulus(const fit::Fit& fit) {
    return fit.parts.front().find(id("bond_youngs_modulus"))->value;
}

class VisibleSize : public testing::TestWithParam<const char*> {};

TEST_P(VisibleSize, IsWhereARefitWithoutTheEffectMissesThreeSigma) {
    const std::string effect = GetParam();
    const auto recordings = fit::observed(recording("T1-null"));
    const fit::FitOptions options = quick_diagnosis(effect).candidate;
    const fit::Fit base = fit::fit_model({}, {}, recordings, options);
    const diagnose::EffectScore score = diagnose::score_effect(
        base, physics::parse_effects(effect, {}).front(), recordings, options, 20);
    ASSERT_TRUE(score.failure.empty()) << score.failure;
    const auto shown =
        recording_with(effect, score.parameter, score.smallest_visible, base, recordings);
    const fit::Fit hidden = fit::fit_model({}, {}, shown, options);
    ASSERT_FALSE(hidden.failed()) << hidden.reason;
    // The size is sought to 20 %, the trace grows with its square at most.
    EXPECT_NEAR(std::sqrt(hidden.chi_squared) / 3.0, 1.0, 0.4);
    const double bias = youngs_modulus(hidden) / youngs_modulus(base) - 1.0;
    EXPECT_NEAR(bias, score.youngs_modulus_bias,
                std::max(0.25 * std::abs(score.youngs_modulus_bias), 1e-4));
}

INSTANTIATE_TEST_SUITE_P(OfFirstAndSecondOrder, VisibleSize,
                         testing::Values("local_defect", "taper", "clamp_compliance", "tip_mass",
                                         "quadratic_drag", "base_motion", "finite_release",
                                         "out_of_plane"));

} // namespace
} // namespace culm::tests
