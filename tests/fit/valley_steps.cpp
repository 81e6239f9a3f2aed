// SPDX-License-Identifier: BSD-3-Clause
// Steps that keep the frequency that a straight step has to first order.
#include "fit/model/stem_model.hpp"
#include "fit/solve/fit.hpp"
#include "fit/solve/residuals.hpp"
#include "run/modes.hpp"
#include "support/parameter_ids.hpp"
#include "support/simulated_measurement.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

namespace {

using namespace culm;

/// The least-squares problem of a stem with a mass at its tip.
class WithTipMass {
  public:
    WithTipMass()
        : measurement_(tests::empty_measurement()), models_{fit::with_effect(
                                                        tests::true_model(measurement_, {}),
                                                        physics::parse_effect("tip_mass", {}),
                                                        measurement_)},
          layout_(fit::joint_layout(models_, {&measurement_, 1})) {
        models_.front().spec.effects.front().values = {1e-6};
        std::vector<fit::ReadingResiduals> parts;
        parts.emplace_back(models_.front(), measurement_,
                           std::vector<double>(measurement_.heights.size(), 5e-5), 1.0,
                           run::Heartbeat{});
        residuals_.emplace(models_, layout_, std::move(parts));
    }

    [[nodiscard]] std::size_t place(const std::string& name) const {
        return static_cast<std::size_t>(std::ranges::find(layout_.ids, tests::id(name)) -
                                        layout_.ids.begin());
    }
    [[nodiscard]] const fit::JointLayout& layout() const { return layout_; }
    [[nodiscard]] const fit::JointResiduals& residuals() const { return *residuals_; }
    [[nodiscard]] std::vector<double> point() const {
        return {residuals_->internal(), residuals_->internal() + residuals_->parameter_count()};
    }
    [[nodiscard]] double log_square(const std::vector<double>& internal) const {
        return 2.0 *
               std::log(run::lowest_frequency_with_effects(residuals_->case_at(internal.data())));
    }

  private:
    fit::ObservedRecording measurement_;
    std::vector<fit::StemModel> models_;
    fit::JointLayout layout_;
    std::optional<fit::JointResiduals> residuals_;
};

TEST(ValleySteps, KeepTheFrequencyOfTheFirstOrder) {
    const WithTipMass problem;
    const fit::ValleySteps valley(problem.residuals(), problem.layout(), {});
    const std::size_t mass = problem.place("tip_mass.mass_kg");
    const std::size_t modulus = problem.place("bond_youngs_modulus");
    const std::vector<double> point = problem.point();

    // The mass grows to a third of the stem's, and Y along the valley's tangent.
    const double stem_mass = problem.residuals().case_at(point.data()).stem.sphere_mass() * 19.0;
    std::vector<double> step(point.size(), 0.0);
    const double per_kg = point[mass] / 1e-6;
    step[mass] = per_kg * stem_mass / 3.0;
    std::vector<double> nearby = point;
    nearby[mass] += 1e-4 * step[mass];
    step[modulus] = -(problem.log_square(nearby) - problem.log_square(point)) / 1e-4;

    std::vector<double> straight = point;
    for (std::size_t k = 0; k < point.size(); ++k)
        straight[k] += step[k];
    std::vector<double> moved(point.size());
    ASSERT_TRUE(valley.Plus(point.data(), step.data(), moved.data()));
    // A straight step along the tangent changes ln f² by about a half ...
    EXPECT_GT(std::abs(problem.log_square(straight) - problem.log_square(point)), 0.3);
    // ... and the curved one only by the error of one-sided slopes, 1e-4 of its 1.5.
    EXPECT_NEAR(problem.log_square(moved), problem.log_square(point), 3e-4);
    straight[modulus] = moved[modulus];
    EXPECT_EQ(moved, straight);
}

TEST(ValleySteps, AreStraightToFirstOrderAndKeepHeldParameters) {
    const WithTipMass problem;
    const std::size_t count = problem.point().size();
    std::vector<bool> is_held(count, false);
    is_held[problem.place("bond_damping")] = true;
    const fit::ValleySteps valley(problem.residuals(), problem.layout(), is_held);
    ASSERT_EQ(valley.TangentSize(), static_cast<int>(count) - 1);
    const std::vector<double> point = problem.point();
    std::vector<double> jacobian(count * (count - 1));
    ASSERT_TRUE(valley.PlusJacobian(point.data(), jacobian.data()));
    for (std::size_t column = 0; column + 1 < count; ++column) {
        constexpr double size = 1e-4;
        std::vector<double> step(count - 1, 0.0);
        step[column] = size;
        std::vector<double> moved(count);
        ASSERT_TRUE(valley.Plus(point.data(), step.data(), moved.data()));
        for (std::size_t k = 0; k < count; ++k)
            // The valley's curvature over the step.
            EXPECT_NEAR((moved[k] - point[k]) / size, jacobian[k * (count - 1) + column], 1e-3)
                << to_string(problem.layout().ids[k]);
    }
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
    const double f_truth = run::lowest_frequency_with_effects(truth.spec);
    const double f_bare = run::lowest_frequency_with_effects(start.spec);
    start.spec.stem.bond_youngs_modulus *= std::pow(f_truth / f_bare, 2);
    const fit::Fit fit = fit::fit_jointly({&start, 1}, {&measurement, 1}, {});
    ASSERT_FALSE(fit.failed()) << fit.reason;
    const auto found =
        std::ranges::find(fit.parameters, tests::id("tip_mass.mass_kg"), &fit::FittedParameter::id);
    ASSERT_NE(found, fit.parameters.end());
    EXPECT_NEAR(found->value, mass, 4.0 * found->standard_error);
    RecordProperty("runs", fit.runs);
    EXPECT_LT(fit.runs, 40);
}

} // namespace
