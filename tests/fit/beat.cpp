// SPDX-License-Identifier: BSD-3-Clause
#include "beam_generator/recording.hpp"
#include "diagnose/models/stem_fit.hpp"
#include "fit/chain/baseline_model.hpp"
#include "fit/chain/prediction.hpp"
#include "fit/chain/stem_model.hpp"
#include "fit/fit_model.hpp"
#include "fit/start/starts.hpp"
#include "physics/effects/library.hpp"
#include "run/simulate.hpp"
#include "support/parameter_ids.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <utility>
#include <variant>
#include <vector>

#include <gtest/gtest.h>

namespace culm::tests {
namespace {

constexpr double angular_frequency = 400.0;
constexpr double decay_rate = 8.0;

/// The fit of a plain swing to the measured motion of three rows.
template <class Motion>
fit::RecordingFit fit_of_plain_swing(const Motion& measured, double noise) {
    constexpr std::array<double, 3> shape{2e-3, 8e-3, 20e-3};
    std::mt19937_64 engine(5);
    std::normal_distribution<double> error(0.0, noise);
    fit::RecordingFit fit;
    fit.prediction.rows = shape.size();
    for (int i = -5; i < 300; ++i) {
        const double time = 1e-3 * i;
        fit.times.push_back(time);
        const double after = std::max(time, 0.0);
        for (const double row : shape) {
            const double plain =
                row * std::exp(-decay_rate * after) * std::cos(angular_frequency * after);
            fit.prediction.readings.push_back(plain);
            fit.residuals.push_back(row * measured(after) + error(engine) - plain);
        }
    }
    fit.prediction.frames = fit.times.size();
    return fit;
}

TEST(RecordedBeats, FindsTheSplitAndTheAngleOfABeat) {
    for (const double split : {0.03, 0.15})
        for (const double angle : {0.5, 1.1}) {
            const auto beat = [&](double time) {
                const double along = std::pow(std::cos(angle), 2);
                return std::exp(-6.0 * time) *
                       (along * std::cos(402.0 * std::sqrt(1.0 + 0.5 * split) * time) +
                        (1.0 - along) * std::cos(402.0 * std::sqrt(1.0 - 0.5 * split) * time));
            };
            const auto beats = fit::recorded_beats(fit_of_plain_swing(beat, 2e-5),
                                                   angular_frequency, decay_rate, 2);
            ASSERT_FALSE(beats.empty()) << split << ' ' << angle;
            // The noise is a thousandth of the swing, over 300 frames, which are less than half a
            // beat of the smaller split; the two modes have their own decay and phase.
            EXPECT_NEAR(beats.front().split, split, 2e-3);
            EXPECT_NEAR(beats.front().angle, angle, 0.05);
            EXPECT_NEAR(beats.front().angular_frequency, 402.0, 0.4);
            EXPECT_NEAR(beats.front().decay_rate, 6.0, 0.1);
            EXPECT_NEAR(beats.front().amplitude, 1.0, 0.01);
        }
}

TEST(RecordedBeats, FindsNoneInAPlainSwing) {
    const auto plain = [](double time) {
        return std::exp(-decay_rate * time) * std::cos(angular_frequency * time);
    };
    EXPECT_TRUE(
        fit::recorded_beats(fit_of_plain_swing(plain, 5e-5), angular_frequency, decay_rate, 2)
            .empty());
}

TEST(RecordedBeats, FindsNoneInAStemThatWasReleasedStraight) {
    fit::RecordingFit fit = fit_of_plain_swing([](double) { return 0.0; }, 5e-5);
    std::ranges::fill(fit.prediction.readings, 0.0);
    EXPECT_TRUE(fit::recorded_beats(fit, angular_frequency, decay_rate, 2).empty());
}

beam::RecordingSpec beating_recording() {
    beam::RecordingSpec spec;
    spec.heights = beam::even_heights(spec.stem.length, 6);
    spec.duration = 0.2;
    spec.errors.noise = 0.04e-3;
    spec.effects = {{"out_of_plane", {{"stiffness_split", 0.1}, {"angle_deg", 35.0}}}};
    return spec;
}

/// Root mean square of the difference over that of the second.
double relative_difference(const std::vector<double>& one, const std::vector<double>& other) {
    double difference = 0.0;
    double size = 0.0;
    for (std::size_t i = 0; i < other.size(); ++i) {
        difference += std::pow(one[i] - other[i], 2);
        size += std::pow(other[i], 2);
    }
    return std::sqrt(difference / size);
}

/// The readings of the spatial chain, which no fit computes, at multiples of the interval.
std::vector<double> spatial_readings(run::CaseSpec spec) {
    spec.integrator.relative_tolerance = 1e-8;
    auto outcome = run::simulate(spec, {});
    return std::get<run::CaseResult>(std::move(outcome)).height_deflection;
}

TEST(Superposition, MatchesTheSpatialChainForASmallSwing) {
    beam::RecordingSpec small = beating_recording();
    small.tip_deflection = 0.5e-3;
    small.errors.noise = 1e-6;
    const measure::Measurement recording = beam::record(small);
    fit::StemModel model = fit::candidate_model(
        fit::baseline_model(recording, {}), physics::parse_effects("out_of_plane", {}), recording);
    model.exposure = 0.0;
    model.spec.duration = 0.2;
    std::vector<double> times;
    for (std::size_t k = 0; k < model.spec.sample_count(); ++k)
        times.push_back(model.release_time + static_cast<double>(k) * model.spec.sample_interval);
    const fit::ChainPrediction planar = fit::predict_readings(model, times, {});
    EXPECT_LT(relative_difference(planar.readings, spatial_readings(model.spec)), 1e-3);
    // The damping of a planar part grows with its stiffness; the split of the spatial chain does
    // not change the damping.
    for (std::size_t k = 0; k < model.parameters.size(); ++k) {
        const fit::FreeParameter& parameter = model.parameters[k];
        const double value = parameter.access.get(model.spec);
        const double step = 1e-3 * std::max(std::abs(value), parameter.access.scale);
        run::CaseSpec below = model.spec;
        run::CaseSpec above = model.spec;
        parameter.access.set(below, value - step);
        parameter.access.set(above, value + step);
        std::vector<double> derivative = spatial_readings(above);
        const std::vector<double> lower = spatial_readings(below);
        std::vector<double> own;
        for (std::size_t at = 0; at < derivative.size(); ++at) {
            derivative[at] = (derivative[at] - lower[at]) / (2.0 * step);
            own.push_back(planar.jacobian[at * planar.parameters + k] *
                          fit::coordinate_slope(parameter.fitted_as, value));
        }
        EXPECT_LT(relative_difference(own, derivative), 0.1) << to_string(model.free_ids()[k]);
    }
    const auto together =
        fit::predict_together(std::vector<fit::StemModel>{model, model}, times, {});
    EXPECT_LT(relative_difference(together[1].readings, planar.readings), 1e-5);
}

// The fit starts from the plain chain, which cannot follow the beat.
TEST(SpatialFit, FindsTheTruthFromTheBeat) {
    const std::vector<fit::ObservedRecording> recordings{
        fit::ObservedRecording(beam::record(beating_recording()))};
    const fit::Fit plain = fit::fit_model({}, {}, recordings);
    const fit::Fit fit =
        diagnose::fit_larger(physics::parse_effects("out_of_plane", {}), plain, recordings, {});
    ASSERT_FALSE(fit.failed()) << fit.reason;
    EXPECT_GT(plain.reduced_chi_squared, 10.0);
    EXPECT_LT(fit.reduced_chi_squared, 1.1);
    EXPECT_LT(fit.batches, 60); // ten times as many where steps are too long for the stem's twist
    const auto value = [&](const std::string& name) {
        return std::ranges::find(fit.parameters, id(name), &fit::FittedParameter::id)->value;
    };
    // Three standard errors are 0.0005 and 0.2 degrees; chain and beam differ by a few thousandths.
    EXPECT_NEAR(value("out_of_plane.stiffness_split"), 0.1, 0.002);
    EXPECT_NEAR(value("out_of_plane.angle_deg"), 35.0, 0.5);
}

} // namespace
} // namespace culm::tests
