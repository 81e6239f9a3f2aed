// SPDX-License-Identifier: BSD-3-Clause
#include "core/error.hpp"
#include "fit/chain/baseline_model.hpp"
#include "fit/chain/stem_model.hpp"
#include "fit/start/starts.hpp"
#include "measure/folder/measurement_folder.hpp"
#include "physics/effects/library.hpp"

#include <filesystem>

#include <gtest/gtest.h>

namespace culm::tests {
namespace {

measure::Measurement quadratic_drag_record() {
    return measure::read_measurement(std::filesystem::path(CULM_TEST_DATA_DIR) / "hidden-effect" /
                                     "T2-quadratic_drag");
}

fit::SelectedEffects effects(const char* text) {
    return physics::parse_effects(text, {});
}

TEST(CandidateModel, DoesNotDependOnTheOrderOfNames) {
    const measure::Measurement measurement = quadratic_drag_record();
    const fit::StemModel baseline = fit::baseline_model(measurement);
    const auto one = fit::candidate_model(
        baseline, effects("quadratic_drag,clamp_compliance,taper"), measurement);
    const auto other = fit::candidate_model(
        baseline, effects("taper,clamp_compliance,quadratic_drag"), measurement);
    EXPECT_EQ(one.free_ids(), other.free_ids());
    ASSERT_EQ(one.spec.effects.size(), 3u);
    for (std::size_t k = 0; k < one.spec.effects.size(); ++k) {
        EXPECT_EQ(one.spec.effects[k].effect, other.spec.effects[k].effect);
        EXPECT_EQ(one.spec.effects[k].values, other.spec.effects[k].values);
    }
}

TEST(CandidateModel, KeepsFixedValuesAndFreesTheOthersWithinBoundsOfTheStem) {
    const measure::Measurement measurement = quadratic_drag_record();
    const auto model = fit::candidate_model(fit::baseline_model(measurement),
                                            effects("clamp_friction(moment_nm=3e-4)"), measurement);
    EXPECT_EQ(model.spec.effects.front().values.front(), 3e-4);
    for (const fit::FreeParameter& parameter : model.parameters)
        EXPECT_NE(to_string(parameter.access.id), "clamp_friction.moment_nm");
    const fit::FreeParameter& stiffness = model.parameters.back();
    EXPECT_EQ(to_string(stiffness.access.id), "clamp_friction.stiffness_nm_rad");
    // The library's bounds for all stems are 1e-8 and 1e8.
    EXPECT_GT(stiffness.lower, 1e-5);
    EXPECT_LT(stiffness.upper, 1e5);
}

TEST(CandidateModel, TakesTheTimeOfTheHoldFromTheMeasurementUnlessItIsFixed) {
    measure::Measurement measurement = quadratic_drag_record();
    const auto hold_time = [&](const char* text) {
        return fit::candidate_model(fit::baseline_model(measurement), effects(text), measurement)
            .spec.effects.front()
            .values.at(2);
    };
    EXPECT_EQ(hold_time("relaxation"), 10.0); // the default
    measurement.hold_time = 3.0;
    EXPECT_EQ(hold_time("relaxation"), 3.0);
    EXPECT_EQ(hold_time("relaxation(hold_time_s=0.5)"), 0.5);
}

TEST(CandidateModel, RefusesEffectsThatCannotBeCombined) {
    const measure::Measurement measurement = quadratic_drag_record();
    fit::SelectedEffects both = effects("clamp_friction");
    both.push_back(effects("clamp_compliance").front());
    EXPECT_THROW(static_cast<void>(
                     fit::candidate_model(fit::baseline_model(measurement), both, measurement)),
                 core::InputError);
}

TEST(CandidateModel, KnowsWhatMovesAStemThatIsHeldStraight) {
    measure::Measurement measurement = quadratic_drag_record();
    measurement.gravity_direction = measure::GravityDirection::Transverse;
    const fit::StemModel baseline = fit::baseline_model(measurement);
    EXPECT_TRUE(fit::can_move(baseline, measurement)); // it was pulled aside
    measurement.release = measure::ReleaseKind::HeldStraight;
    EXPECT_FALSE(fit::can_move(baseline, measurement));
    const auto moves = [&](const char* text) {
        return fit::can_move(fit::candidate_model(baseline, effects(text), measurement),
                             measurement);
    };
    EXPECT_TRUE(moves("gravity"));
    EXPECT_TRUE(moves("precurvature"));
    EXPECT_FALSE(moves("quadratic_drag,clamp_compliance"));
}

TEST(CandidateEffects, AreAllOfTheLibraryWhereTheDirectionOfGravityIsKnown) {
    std::vector<measure::Measurement> recordings(1);
    recordings.front().gravity_direction = measure::GravityDirection::Axial;
    const auto names = fit::model_names(fit::candidate_effects(recordings));
    // The baseline is one of them; plate_air needs a section with edges.
    EXPECT_EQ(names.size(), physics::all_effects().size());
    recordings.front().stem.section = measure::RectangularSection{0.05, 0.002};
    EXPECT_EQ(fit::candidate_effects(recordings).size(), physics::all_effects().size());
}

TEST(PlaceParameters, BelongToTheLibrary) {
    std::size_t places = 0;
    for (const physics::EffectPointer& effect : physics::all_effects())
        for (const physics::EffectParameter& parameter : effect->parameters)
            places += parameter.is_place ? 1 : 0;
    // local_defect.position_m, relaxation.time_s, two of base_motion, out_of_plane.angle_deg,
    // clamp_friction.stiffness_nm_rad, power_drag.exponent, two of fractional_zener,
    // clamp_compliance.loss_factor, amplitude_damping.exponent, two of clamp_slip.
    EXPECT_EQ(places, 13u);
}

} // namespace
} // namespace culm::tests
