// SPDX-License-Identifier: BSD-3-Clause
#include "beam_generator/recording.hpp"
#include "diagnose/diagnosis.hpp"
#include "diagnose/models/stem_fit.hpp"
#include "fit/fit_model.hpp"
#include "physics/effects/library.hpp"
#include "support/parameter_ids.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace {

using namespace culm;
using Recordings = std::vector<fit::ObservedRecording>;

/// A recording of the beam generator, whose model is not the chain: 0.2 s of a stem of 84 mg, with
/// 0.05 mm of noise. A chain of 28 spheres makes the fit quick.
fit::ObservedRecording beam(const std::string& id, double deflection,
                            std::vector<beam::HiddenEffect> effects = {}) {
    beam::RecordingSpec spec;
    spec.id = id;
    spec.tip_deflection = deflection;
    spec.effects = std::move(effects);
    spec.heights = beam::even_heights(spec.stem.length, 6);
    spec.duration = 0.2;
    spec.errors.noise = 0.05e-3;
    spec.seed = static_cast<std::uint64_t>(id.front());
    fit::ObservedRecording recording(beam::record(spec));
    recording.stem.spheres = 28;
    return recording;
}

fit::SelectedEffects effects(const std::vector<std::string>& names) {
    fit::SelectedEffects selected;
    for (const std::string& name : names) {
        const physics::EffectPointer effect = physics::effect_named(name);
        selected.push_back({effect, std::vector<std::optional<double>>(effect->parameters.size())});
    }
    return selected;
}

const fit::FittedParameter& parameter(const fit::Fit& fit, const std::string& name) {
    const auto found =
        std::ranges::find(fit.parameters, tests::id(name), &fit::FittedParameter::id);
    if (found == fit.parameters.end())
        throw std::runtime_error(name + " was not fitted: " + fit.reason);
    return *found;
}

TEST(Fit, FindsOneMaterialForTwoReleasesOfOneStem) {
    const Recordings two{beam("a", 20e-3), beam("b", 15e-3)};
    const fit::Fit fit = fit::fit_model({}, {}, two);
    ASSERT_FALSE(fit.failed()) << fit.reason;
    // Y is 2.2 GPa; 1 % is for the errors of a chain of 28 spheres and of the generator's mesh.
    EXPECT_NEAR(parameter(fit, "bond_youngs_modulus").value, 2.2e9, 0.01 * 2.2e9);
    EXPECT_NEAR(parameter(fit, "tip_deflection@a").value, 20e-3, 0.05e-3);
    EXPECT_NEAR(parameter(fit, "tip_deflection@b").value, 15e-3, 0.05e-3);
    // 2400 degrees of freedom: a standard error of 2.9 %; the models differ by some hundredths.
    EXPECT_NEAR(fit.reduced_chi_squared, 1.0, 0.15);
    const double alone = fit::fit_model({}, {}, {two.data(), 1}).parameters.front().standard_error;
    EXPECT_LT(parameter(fit, "bond_youngs_modulus").standard_error, 0.9 * alone);
}

TEST(Fit, FindsAHiddenTipMassNextToARecordingWithoutIt) {
    const double mass = 10e-6; // a quarter of the stem's: its frequency falls by a third
    const Recordings two{beam("a", 20e-3), beam("b", 20e-3, {{"tip_mass", {{"mass_kg", mass}}}})};
    const fit::Fit baseline = fit::fit_model({}, {}, two);
    ASSERT_FALSE(baseline.failed()) << baseline.reason;
    EXPECT_GT(baseline.reduced_chi_squared, 100.0); // no material suits both
    const fit::Fit fit = diagnose::fit_larger(effects({"tip_mass"}), baseline, two, {});
    ASSERT_FALSE(fit.failed()) << fit.reason;
    EXPECT_NEAR(fit.reduced_chi_squared, 1.0, 0.15); // as above
    const double extra =
        parameter(fit, "tip_mass.mass_kg@b").value - parameter(fit, "tip_mass.mass_kg@a").value;
    EXPECT_NEAR(extra, mass, 0.05 * mass);
    EXPECT_NEAR(parameter(fit, "bond_youngs_modulus").value, 2.2e9, 0.02 * 2.2e9);
}

TEST(Diagnosis, NamesAMassInTheRecordingThatCarriesItAndInNoOther) {
    const double mass = 10e-6;
    std::vector<measure::Measurement> two{beam("a", 20e-3),
                                          beam("b", 20e-3, {{"tip_mass", {{"mass_kg", mass}}}})};
    two.front().specimen = two.back().specimen = "stem";
    diagnose::DiagnosisOptions options;
    options.candidates = effects({"tip_mass"});
    const diagnose::Diagnosis found = diagnose::diagnose(diagnose::specimens_of(two), options);
    ASSERT_EQ(found.conclusion, diagnose::Conclusion::Effect) << found.reason;
    const std::vector<fit::FittedParameter>& numbers = found.ladder.back().fit.parameters;
    const auto named = [&](const std::string& name) {
        return std::ranges::find(numbers, tests::id(name), &fit::FittedParameter::id);
    };
    EXPECT_EQ(named("tip_mass.mass_kg@a"), numbers.end());
    ASSERT_NE(named("tip_mass.mass_kg@b"), numbers.end());
    // Length, diameter and density are known to 0.2, 1 and 1 %, the mass of a stem to 2.2 %. The
    // tip mass depends on it, as its interval shows.
    EXPECT_NEAR(named("tip_mass.mass_kg@b")->value, mass,
                3.0 * named("tip_mass.mass_kg@b")->standard_error);
    EXPECT_LT(interval_half_width(*named("tip_mass.mass_kg@b")), 0.06 * mass);
}

TEST(Fit, DoesNotDependOnTheOrderOfTheRecordings) {
    Recordings two{beam("a", 20e-3), beam("b", 15e-3, {{"tip_mass", {{"mass_kg", 5e-6}}}})};
    const auto fitted = [&] {
        return diagnose::fit_larger(effects({"tip_mass"}), fit::fit_model({}, {}, two, {}), two);
    };
    const fit::Fit one = fitted();
    std::ranges::reverse(two);
    const fit::Fit other = fitted();
    ASSERT_TRUE(one.is_fitted() && other.is_fitted()) << one.reason << other.reason;
    // Solutions end when an iteration changes χ² by less than 0.1 of one standard error's change.
    EXPECT_NEAR(one.chi_squared, other.chi_squared, 0.2);
}

TEST(Fit, FindsOneValueForAnEffectOfBothRecordings) {
    const std::vector<beam::HiddenEffect> yielding{
        {"clamp_compliance", {{"stiffness_nm_rad", 0.7}}}};
    const Recordings two{beam("a", 20e-3, yielding), beam("b", 12e-3, yielding)};
    const fit::Fit fit =
        diagnose::fit_larger(effects({"clamp_compliance"}), fit::fit_model({}, {}, two, {}), two);
    ASSERT_FALSE(fit.failed()) << fit.reason;
    const double stiffness = parameter(fit, "clamp_compliance.stiffness_nm_rad").value;
    EXPECT_NEAR(stiffness, 0.7, 0.05 * 0.7);
    EXPECT_NEAR(fit.reduced_chi_squared, 1.0, 0.15); // as above
}

TEST(Fit, DoesNotMoveForStraightReleasesWithoutGravity) {
    Recordings two{beam("a", 20e-3), beam("b", 15e-3)};
    for (measure::Measurement& recording : two)
        recording.release = measure::ReleaseKind::HeldStraight;
    const fit::Fit baseline = fit::fit_model({}, {}, two);
    EXPECT_FALSE(baseline.moves());
    EXPECT_FALSE(diagnose::fit_larger(effects({"tip_mass"}), baseline, two, {}).moves());
}

TEST(Fit, FailsWithAReasonForACandidateThatCannotBeApplied) {
    const Recordings two{beam("a", 20e-3), beam("b", 15e-3)};
    const fit::Fit fit =
        diagnose::fit_larger(effects({"gravity"}), fit::fit_model({}, {}, two, {}), two);
    EXPECT_FALSE(fit.is_fitted());
    EXPECT_NE(fit.reason.find("gravity has no direction"), std::string::npos) << fit.reason;
    EXPECT_EQ(fit.names(), (std::vector<std::string>{"baseline", "gravity"}));
}

} // namespace
