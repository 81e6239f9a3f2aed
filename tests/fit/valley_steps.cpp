// SPDX-License-Identifier: BSD-3-Clause
// Steps that keep the first mode that a straight step has to first order.
#include "fit/chain/stem_model.hpp"
#include "fit/fit.hpp"
#include "run/modes.hpp"
#include "support/parameter_ids.hpp"
#include "support/simulated_measurement.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace {

using namespace culm;

fit::StartModels moved_in_valley(const fit::StartModels& models, const fit::JointLayout& layout,
                                 const Eigen::VectorXd& step) {
    return fit::in_valley([&](double share) { return fit::moved(models, layout, share * step); },
                          layout);
}

// The mass grows to a third of the stem's, and Y along the valley's tangent.
TEST(ValleySteps, KeepTheModeOfTheFirstOrder) {
    const fit::ObservedRecording measurement(tests::empty_measurement());
    fit::StartModels models{fit::with_effect(tests::true_model(measurement, {}),
                                             physics::parse_effect("tip_mass", {}), measurement)};
    models.front().spec.effects.front().values = {1e-6};
    const fit::JointLayout layout = fit::joint_layout(models, {&measurement, 1});
    const auto place = [&](const std::string& name) {
        return std::ranges::find(layout.ids, tests::id(name)) - layout.ids.begin();
    };
    const auto log_square = [](const fit::StartModels& at) {
        return 2.0 * std::log(run::lightly_damped_mode(at.front().spec).frequency);
    };
    const double stem_mass = models.front().spec.stem.sphere_mass() * 19.0;
    Eigen::VectorXd step = Eigen::VectorXd::Zero(std::ssize(layout.ids));
    step(place("tip_mass.mass_kg")) = stem_mass / 3.0;
    step(place("bond_youngs_modulus")) =
        -(log_square(fit::moved(models, layout, 1e-4 * step)) - log_square(models)) / 1e-4;

    const fit::StartModels straight = fit::moved(models, layout, step);
    const fit::StartModels curved = moved_in_valley(models, layout, step);
    // A straight step along the tangent changes ln f² by about a half ...
    EXPECT_GT(std::abs(log_square(straight) - log_square(models)), 0.3);
    // ... and the curved one only by the error of one-sided slopes, 1e-4 of its 1.5.
    EXPECT_NEAR(log_square(curved), log_square(models), 3e-4);
    const auto decay = [](const fit::StartModels& at) {
        return run::lightly_damped_mode(at.front().spec).decay_rate;
    };
    const double slope = (decay(fit::moved(models, layout, 1e-4 * step)) - decay(models)) / 1e-4;
    EXPECT_NEAR(decay(curved) / (decay(models) + slope), 1.0, 1e-2);
    EXPECT_GT(std::abs(decay(straight) / (decay(models) + slope) - 1.0), 0.05);
    for (std::size_t k = 0; k < layout.ids.size(); ++k) {
        if (layout.ids[k] != physics::bond_youngs_modulus &&
            layout.ids[k] != physics::bond_damping) {
            EXPECT_EQ(curved.front().value(k), straight.front().value(k));
        }
    }
}

TEST(ValleySteps, AreStraightToFirstOrder) {
    const fit::ObservedRecording measurement(tests::empty_measurement());
    const fit::StartModels models{fit::with_effect(
        tests::true_model(measurement, {}), physics::parse_effect("tip_mass", {}), measurement)};
    const fit::JointLayout layout = fit::joint_layout(models, {&measurement, 1});
    const Eigen::VectorXd step = Eigen::VectorXd::Constant(std::ssize(layout.ids), 1e-10);
    const fit::StartModels straight = fit::moved(models, layout, step);
    const fit::StartModels curved = moved_in_valley(models, layout, step);
    EXPECT_NEAR(curved.front().spec.stem.bond_youngs_modulus /
                    straight.front().spec.stem.bond_youngs_modulus,
                1.0, 1e-7); // the error of slopes over the step
}

TEST(ValleySteps, FindAMassFromZeroInFewRuns) {
    const measure::Measurement empty = tests::empty_measurement();
    fit::StemModel truth = fit::with_effect(tests::true_model(empty, {}),
                                            physics::parse_effect("tip_mass", {}), empty);
    const double mass = truth.spec.stem.sphere_mass() * 19.0 * 0.3;
    truth.spec.effects.front().values = {mass};
    const fit::ObservedRecording measurement(tests::read_with_noise(empty, truth, 3));
    fit::StemModel start = truth;
    start.spec.effects.front().values = {0.0};
    // Y is that of a fit without the mass, which has the right frequency.
    const double f_truth = run::lightly_damped_mode(truth.spec).frequency;
    const double f_bare = run::lightly_damped_mode(start.spec).frequency;
    start.spec.stem.bond_youngs_modulus *= std::pow(f_truth / f_bare, 2);
    const fit::Fit fit = fit::fit_jointly({&start, 1}, {&measurement, 1}, {});
    ASSERT_FALSE(fit.failed()) << fit.reason;
    const auto found =
        std::ranges::find(fit.parameters, tests::id("tip_mass.mass_kg"), &fit::FittedParameter::id);
    ASSERT_NE(found, fit.parameters.end());
    EXPECT_NEAR(found->value, mass, 4.0 * found->standard_error);
    RecordProperty("batches", fit.batches);
    EXPECT_LT(fit.batches, 40);
}

} // namespace
