// SPDX-License-Identifier: BSD-3-Clause
// Fits of the chain of spheres to recordings of the beam, a model that shares no code with it.
#include "beam_generator/random_case.hpp"
#include "beam_generator/recording.hpp"
#include "fit/chain/stem_chain.hpp"
#include "fit/fit_model.hpp"
#include "support/parameter_ids.hpp"
#include "support/single_fit.hpp"

#include <string>

#include <fmt/core.h>
#include <gtest/gtest.h>

namespace culm::beam {
namespace {

RecordingSpec recording(std::vector<HiddenEffect> effects, double noise) {
    RecordingSpec spec;
    spec.heights = even_heights(spec.stem.length, 8);
    spec.duration = 0.25;
    spec.effects = std::move(effects);
    spec.errors.noise = noise;
    return spec;
}

TEST(Chain, RecoversModulusAndDampingOfAPlainBeam) {
    const RecordingSpec spec = recording({}, 0.0);
    const fit::Fit fit = tests::fit_baseline(record(spec));
    ASSERT_FALSE(fit.failed()) << fit.reason;
    // 56 spheres at 20 mm: seen 0.2 µm, Y + 0.06 %, τ + 0.01 %. Noise is a hundred times that.
    EXPECT_LT(fit.parts.front().rmse, 1e-6);
    const run::CaseSpec& found = fit.parts.front().model.spec;
    EXPECT_NEAR(found.stem.bond_youngs_modulus / spec.stem.youngs_modulus, 1.0, 2e-3);
    EXPECT_NEAR(fit::damping_time(found) / spec.stem.damping_time, 1.0, 2e-3);
    EXPECT_NEAR(found.tip_deflection, spec.tip_deflection, 1e-6);
}

/// Adds the true effect: the error falls to the noise and the parameter is recovered.
void expect_found(const HiddenEffect& effect, const std::string& parameter, double tolerance) {
    const RecordingSpec spec = recording({effect}, 5e-5);
    const measure::Measurement measurement = record(spec);
    const fit::Fit baseline = tests::fit_baseline(measurement);
    ASSERT_FALSE(baseline.failed()) << baseline.reason;
    EXPECT_GT(baseline.parts.front().rmse, 1.3 * spec.errors.noise) << effect.name;
    const fit::Fit fit =
        tests::fit_candidate(physics::parse_effects(effect.name, {}), baseline, measurement);
    ASSERT_FALSE(fit.failed()) << effect.name << ": " << fit.reason;
    // 2000 readings: their root mean square has a standard error of 1.6 %.
    EXPECT_LT(fit.parts.front().rmse, 1.05 * spec.errors.noise) << effect.name;
    const auto* const found = fit.parts.front().find({effect.name, parameter, {}});
    ASSERT_NE(found, nullptr);
    const double truth = effect.value(parameter);
    EXPECT_NEAR(found->value / truth, 1.0, tolerance) << effect.name;
    EXPECT_LT(std::abs(found->value - truth), 4.0 * found->standard_error) << effect.name;
}

// Tolerances are some three standard errors of such a record.
TEST(Chain, FindsTheDragOfTheBeam) {
    expect_found({"quadratic_drag", {{"drag_coefficient", 1.2}}}, "drag_coefficient", 0.05);
}

TEST(Chain, FindsTheClampOfTheBeam) {
    expect_found({"clamp_compliance", {{"stiffness_nm_rad", 1.0}}}, "stiffness_nm_rad", 0.1);
}

TEST(Chain, FindsTheSofteningOfTheBeam) {
    expect_found({"bending_nonlinearity", {{"gamma_m2", -0.01}}}, "gamma_m2", 0.05);
}

TEST(Chain, FindsTheRelaxationOfTheBeam) {
    expect_found({"relaxation", {{"fraction", 0.03}, {"time_s", 0.15}, {"hold_time_s", 10.0}}},
                 "fraction", 0.1);
}

// Only the second mode, which dies within five frames, separates the tip mass from Y and β. Along
// this valley χ² rises a million times less than across it. A solution that stops in it is wrong by
// many standard errors, although the residuals look like noise.
TEST(Chain, EndsAtTheBestMassAtTheTipAndNotInTheValleyBeforeIt) {
    const RecordingSpec spec = random_case(1, CaseKind::Single, 30).spec;
    const double truth = spec.effects.front().value("mass_kg");
    const measure::Measurement measurement = record(spec);
    const fit::Fit baseline = tests::fit_baseline(measurement);
    const auto fitted = [&](const std::string& effect) {
        return tests::fit_candidate(physics::parse_effects(effect, {}), baseline, measurement);
    };
    const fit::Fit free = fitted("tip_mass");
    const fit::Fit fixed = fitted(fmt::format("tip_mass(mass_kg={:.12g})", truth));
    ASSERT_FALSE(free.failed() || fixed.failed()) << free.reason << fixed.reason;
    // A free mass cannot fit worse, up to ~ 1 for Huber's loss and the noise of the runs.
    EXPECT_LT(free.parts.front().chi_squared, fixed.parts.front().chi_squared + 1.0);
    const auto* const mass = free.parts.front().find(tests::id("tip_mass.mass_kg"));
    ASSERT_NE(mass, nullptr);
    EXPECT_LT(std::abs(mass->value - truth), 3.0 * mass->standard_error);
}

} // namespace
} // namespace culm::beam
