// SPDX-License-Identifier: BSD-3-Clause
#include "diagnose/adequacy.hpp"
#include "fit/chain/baseline_model.hpp"
#include "fit/chain/stem_model.hpp"
#include "physics/effects/library.hpp"
#include "support/parameter_ids.hpp"
#include "support/simulated_measurement.hpp"
#include "support/single_fit.hpp"

#include <gtest/gtest.h>

namespace {

using namespace culm;

bool is_adequate(const fit::RecordingFit& fit, const measure::Measurement& measurement) {
    return diagnose::verdict_on(fit, residuals::swing_of(fit, measurement)).finding ==
           diagnose::Finding::Adequate;
}

TEST(LackOfFit, IsNotSeenWhereNothingIsMissing) {
    int alarms = 0;
    for (unsigned seed = 1; seed <= 10; ++seed) {
        const auto measurement = tests::simulated_measurement({}, seed);
        const auto fit = tests::fit_chain(fit::baseline_model(measurement), measurement);
        alarms += is_adequate(fit, measurement) ? 0 : 1;
    }
    EXPECT_LE(alarms, 1); // at a rate of 1 %, two of ten have a probability of 0.4 %
}

TEST(LackOfFit, IsSeenWhereTheDragOfTheAirIsMissing) {
    measure::Measurement measurement = tests::empty_measurement();
    physics::SelectedEffect drag;
    drag.effect = physics::effect_named("quadratic_drag");
    drag.fixed.assign(drag.effect->parameters.size(), std::nullopt);
    fit::StemModel truth = fit::with_effect(tests::true_model(measurement, {}), drag, measurement);
    truth.parameters.resize(3);
    measurement = tests::read_with_noise(measurement, truth, 1);
    const auto fit = tests::fit_chain(fit::baseline_model(measurement), measurement);
    const diagnose::Verdict verdict =
        diagnose::verdict_on(fit, residuals::swing_of(fit, measurement));
    EXPECT_EQ(verdict.finding, diagnose::Finding::Inadequate) << fit.reduced_chi_squared;
    EXPECT_NE(verdict.reason.find("correlation of the swing"), std::string::npos) << verdict.reason;
}

TEST(EffectParameters, AreFoundTogetherWithTheBaselines) {
    measure::Measurement measurement = tests::empty_measurement();
    physics::SelectedEffect drag;
    drag.effect = physics::effect_named("quadratic_drag");
    drag.fixed = {1.5};
    ASSERT_EQ(drag.effect->parameters.size(), 1U);
    const fit::StemModel truth =
        fit::with_effect(tests::true_model(measurement, {}), drag, measurement);
    EXPECT_EQ(truth.parameters.size(), 3U); // fixed, so not free
    measurement = tests::read_with_noise(measurement, truth, 2);
    drag.fixed = {std::nullopt};
    const fit::RecordingFit fit = tests::fit_chain(
        fit::with_effect(fit::baseline_model(measurement), drag, measurement), measurement);
    const fit::FittedParameter* found = fit.find(tests::id("quadratic_drag.drag_coefficient"));
    ASSERT_NE(found, nullptr);
    EXPECT_LT(std::abs(found->value - 1.5), 4.0 * found->standard_error);
    EXPECT_LT(found->standard_error, 0.5); // the record determines it
    EXPECT_TRUE(is_adequate(fit, measurement));
}

} // namespace
