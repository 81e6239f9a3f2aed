// SPDX-License-Identifier: BSD-3-Clause
// Compares the error terms of the second mode with beams whose second mode has another frequency or
// another loss (the beam generator shares no code with the chain).
#include "beam_generator/recording.hpp"
#include "diagnose/adequacy.hpp"
#include "diagnose/evidence/log_evidence.hpp"
#include "fit/errors/terms.hpp"
#include "fit/fit_model.hpp"
#include "fit/linear/scaled_solve.hpp"
#include "fit/solve/residual_statistics.hpp"

#include <cmath>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>
#include <gtest/gtest.h>

namespace culm::tests {
namespace {

beam::RecordingSpec clean_spec() {
    beam::RecordingSpec spec;
    spec.heights = beam::even_heights(spec.stem.length, 8);
    spec.duration = 0.3;
    spec.errors.noise = 0.02e-3;
    return spec;
}

/// The exact recording with the stated noise.
measure::Measurement exact(beam::RecordingSpec spec) {
    const double noise = spec.errors.noise;
    spec.errors = {};
    measure::Measurement measurement = beam::record(spec);
    measurement.noise = noise;
    measurement.stem.spheres = 20;
    return measurement;
}

Eigen::VectorXd vector_of(const std::vector<double>& values) {
    return Eigen::Map<const Eigen::VectorXd>(values.data(),
                                             static_cast<Eigen::Index>(values.size()));
}

fit::Fit chain_fitted_to(const measure::Measurement& recording) {
    fit::FitOptions exact;
    exact.with_inputs = false;
    return fit::fit_model({}, {}, fit::observed({&recording, 1}), exact);
}

/// The term of a name; its readings are empty if there is none.
fit::ErrorTerm term(const std::vector<fit::ErrorTerm>& terms, const std::string& what) {
    for (const fit::ErrorTerm& each : terms)
        if (each.id.starts_with(what))
            return each;
    return {};
}

/// Term over derivative, without the parts that the fit's own numbers imitate: the cosine of their
/// angle, and the ratio of their lengths.
std::pair<double, double> compared(const fit::Fit& fit, const Eigen::VectorXd& term,
                                   const Eigen::VectorXd& derivative) {
    const Eigen::Index readings = fit.system.readings();
    const fit::Projector own(fit.system.jacobian.topRows(readings));
    const double noise = fit.parts.front().noise.front();
    const Eigen::VectorXd left = own.remainder(term / noise);
    const Eigen::VectorXd right = own.remainder(derivative / noise);
    return {left.dot(right) / left.norm() / right.norm(), left.norm() / right.norm()};
}

class SecondModeErrors : public ::testing::TestWithParam<double> {};

TEST_P(SecondModeErrors, AreThoseOfABeamWithAnotherSecondMode) {
    beam::RecordingSpec spec = clean_spec();
    spec.frames_per_second = GetParam();
    const measure::Measurement recording = exact(spec);
    const fit::Fit fit = chain_fitted_to(recording);
    ASSERT_FALSE(fit.failed()) << fit.reason;
    const fit::RecordingFit& part = fit.parts.front();
    const auto terms = fit::second_mode_terms(part, recording);
    ASSERT_EQ(terms.size(), 2u);

    spec.law_errors.second_frequency_share = 0.005;
    const Eigen::VectorXd higher = vector_of(exact(spec).deflections);
    spec.law_errors.second_frequency_share = -0.005;
    const Eigen::VectorXd lower = vector_of(exact(spec).deflections);
    const auto [like, length] = compared(fit, vector_of(term(terms, "frequency").readings),
                                         (higher - lower) / std::log(1.005 / 0.995));
    EXPECT_GT(like, 0.95);
    // η of the beam at mode 1 is ω₁ τ, and f₂/f₁ of a cantilever 6.267.
    const double loss =
        2.0 * std::numbers::pi * spec.stem.first_frequency() * spec.stem.damping_time;
    EXPECT_NEAR(length / (2.0 / std::numbers::pi * loss * std::log(6.267)), 1.0, 0.15);

    spec.law_errors = {};
    spec.law_errors.second_loss_ratio = 1.05;
    const Eigen::VectorXd more = vector_of(exact(spec).deflections);
    spec.law_errors.second_loss_ratio = 0.95;
    const Eigen::VectorXd less = vector_of(exact(spec).deflections);
    const auto [like_loss, length_of_loss] = compared(fit, vector_of(term(terms, "loss").readings),
                                                      (more - less) / std::log(1.05 / 0.95));
    EXPECT_GT(like_loss, 0.95);
    EXPECT_NEAR(length_of_loss / std::log(1.5), 1.0, 0.2);
}

// 350 frames per second are too slow for the second mode, and show it at another frequency.
INSTANTIATE_TEST_SUITE_P(Cameras, SecondModeErrors, ::testing::Values(350.0, 1000.0, 3000.0));

// The frequency is wrong by less than one standard uncertainty of its term.
TEST(SecondMode, AccountsForAnotherFrequency) {
    beam::RecordingSpec spec = clean_spec();
    spec.stem.damping_time = 4e-5; // the second mode is seen for some cycles
    spec.law_errors.second_frequency_share = 0.02;
    spec.frames_per_second = 2000.0;
    spec.errors.noise = 0.01e-3;
    measure::Measurement recording = beam::record(spec);
    recording.stem.spheres = 20;
    const fit::BaselineFit fit = fit::fit_baseline({&recording, 1});
    ASSERT_FALSE(fit.fit.failed()) << fit.fit.reason;
    fit::Fit exact = fit.fit;
    exact.parts.front().remaining = exact.parts.front().residuals;
    EXPECT_EQ(diagnose::verdict_on(exact, fit.recordings).finding, diagnose::Finding::Inadequate);
    EXPECT_EQ(diagnose::verdict_on(fit.fit, fit.recordings).finding, diagnose::Finding::Adequate);
}

// −½ log |I + MᵀM| of the model's own terms.
TEST(LogEvidence, CountsTheDeterminantOfTheTermsOfTheModel) {
    diagnose::ModelEvidence evidence;
    evidence.misfits = {100.0};
    diagnose::NoiseScale noise{{1.0}, {true}, {100}};
    const double without = diagnose::log_evidence(evidence, noise);
    evidence.model_terms = Eigen::MatrixXd{{3.0, 1.0}, {1.0, 2.0}};
    EXPECT_NEAR(diagnose::log_evidence(evidence, noise) - without, -0.5 * std::log(11.0), 1e-12);
}

} // namespace
} // namespace culm::tests
