// SPDX-License-Identifier: BSD-3-Clause
#include "diagnose/diagnosis.hpp"

#include "diagnosis_records.hpp"
#include "fit/fit_numbers.hpp"
#include "support/parameter_ids.hpp"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

namespace culm::tests {
namespace {

using Outcomes = std::vector<core::ItemOutcome<core::Bytes>>;

using diagnose::Conclusion;

const fit::FittedParameter& parameter(const fit::Fit& fit, const std::string& name) {
    return *std::ranges::find(fit.parameters, id(name), &fit::FittedParameter::id);
}

TEST(Diagnosis, NamesNothingWhereNothingIsMissing) {
    const auto recordings = recording("T1-null");
    const diagnose::Diagnosis found = diagnose::diagnose(
        diagnose::specimens_of(recordings),
        quick_diagnosis("taper,bending_nonlinearity,clamp_compliance,tip_mass,quadratic_drag"));
    EXPECT_EQ(found.conclusion, Conclusion::Adequate) << found.reason;
    EXPECT_TRUE(found.effects.empty());
    EXPECT_EQ(found.ladder.size(), 1u);
    ASSERT_EQ(found.detection_limits.size(), 5u);
    // A mass that this record cannot show would appear as a softer stem.
    const auto tip_mass =
        std::ranges::find(found.detection_limits, "tip_mass", &diagnose::DetectionLimit::effect);
    ASSERT_NE(tip_mass, found.detection_limits.end());
    EXPECT_LT(tip_mass->youngs_modulus_bias, 0.0);
    EXPECT_GT(found.probability, 0.5);
    EXPECT_FALSE(found.next_experiments.empty());
}

TEST(Diagnosis, NamesDragAndItsStrength) {
    const auto recordings = recording("T2-quadratic_drag");
    const diagnose::Diagnosis found =
        diagnose::diagnose(diagnose::specimens_of(recordings),
                           quick_diagnosis("viscous_drag,hysteretic_damping,quadratic_drag,taper"));
    EXPECT_EQ(found.conclusion, Conclusion::Effect) << found.reason;
    ASSERT_EQ(found.effects, std::vector<std::string>{"quadratic_drag"});
    ASSERT_EQ(found.ladder.size(), 2u);
    EXPECT_EQ(found.ladder.back().verdict.finding, diagnose::Finding::Adequate) << found.reason;
    // The truth is 1.3. Two standard errors are 0.01; the rest is the error of the model.
    EXPECT_NEAR(parameter(found.ladder.back().fit, "quadratic_drag.drag_coefficient").value, 1.3,
                0.05);
    EXPECT_GT(found.probability, 0.95);
    EXPECT_GT(found.ladder.back().log_evidence, 1e4);
    EXPECT_GT(found.explained, 0.99);
}

TEST(Diagnosis, DoesNotDependOnTheOrderOfCandidatesOrOfTheWork) {
    const auto recordings = recording("T2-quadratic_drag");
    const diagnose::Diagnosis one = diagnose::diagnose(
        diagnose::specimens_of(recordings), quick_diagnosis("taper,quadratic_drag,viscous_drag"));
    diagnose::DiagnosisOptions other = quick_diagnosis("viscous_drag,taper,quadratic_drag");
    other.map = core::ItemMap([](const std::vector<double>& costs, const auto& work) {
        Outcomes outcomes(costs.size());
        for (std::size_t item = costs.size(); item-- > 0;)
            outcomes[item].value = work(item, {}).bytes;
        return outcomes;
    });
    const diagnose::Diagnosis two = diagnose::diagnose(diagnose::specimens_of(recordings), other);
    EXPECT_EQ(one.effects, two.effects);
    ASSERT_EQ(one.posterior.models.size(), two.posterior.models.size());
    for (std::size_t k = 0; k < one.posterior.models.size(); ++k) {
        EXPECT_EQ(one.posterior.models[k].effects, two.posterior.models[k].effects);
        EXPECT_EQ(one.posterior.models[k].log_evidence, two.posterior.models[k].log_evidence);
    }
    EXPECT_EQ(core::encoded(one.ladder.back().fit), core::encoded(two.ladder.back().fit));
}

TEST(Diagnosis, NamesNoEffectAndFindsTheForceWithoutTheTrueEffect) {
    const auto recordings = recording("T2-quadratic_drag");
    const diagnose::Diagnosis found = diagnose::diagnose(
        diagnose::specimens_of(recordings), quick_diagnosis("taper,viscous_drag,clamp_compliance"));
    EXPECT_EQ(found.conclusion, Conclusion::Unknown) << found.reason;
    EXPECT_TRUE(found.effects.empty());
    ASSERT_TRUE(found.missing_force);
    EXPECT_EQ(found.missing_force->kind, "force_per_length");
    ASSERT_FALSE(found.missing_force->terms.empty());
    EXPECT_EQ(found.missing_force->terms.front().term, "v*abs(v)") << found.missing_force->form;
    // −½ ρ d C_d with ρ = 1.2 kg/m³ and C_d = 1.3; other terms may absorb a tenth of it.
    const double wanted =
        -0.5 * 1.2 * std::get<measure::CircularSection>(recordings.front().stem.section).diameter *
        1.3;
    EXPECT_NEAR(found.missing_force->terms.front().coefficient / wanted, 1.0, 0.15);
    EXPECT_NE(found.missing_force->character.find("dissipative"), std::string::npos);
    EXPECT_GT(found.missing_force->explained, 0.95);
    EXPECT_NE(found.missing_force->as_effect_file.find("expression = \"c1*v*abs(v)"),
              std::string::npos);
}

TEST(Diagnosis, VisitsEveryModelThatMayMatter) {
    const auto recordings = recording("T2-quadratic_drag");
    const diagnose::Diagnosis found = diagnose::diagnose(
        diagnose::specimens_of(recordings),
        quick_diagnosis("taper,viscous_drag,quadratic_drag,power_drag,tip_mass"));
    ASSERT_TRUE(found.largest_unvisited);
    EXPECT_LT(found.largest_unvisited->log_evidence, -found.policy.unvisited_margin);
}

// The exponent of power_drag fits any drag: one recording names the family.
TEST(Diagnosis, NamesTheFamilyAndItsLikeliestLaw) {
    const auto recordings = recording("T2-quadratic_drag");
    const diagnose::Diagnosis found =
        diagnose::diagnose(diagnose::specimens_of(recordings), quick_diagnosis("power_drag,taper"));
    EXPECT_EQ(found.conclusion, Conclusion::Effect) << found.reason;
    ASSERT_EQ(found.families.size(), 1u);
    EXPECT_EQ(found.families.front().family, physics::Family::Air);
    EXPECT_TRUE(found.families.front().is_open);
    EXPECT_EQ(found.families.front().members, std::vector<std::string>{"power_drag"});
}

TEST(Diagnosis, TriesNoOtherLawOfDragBesideTheAnswer) {
    const auto recordings = recording("T2-quadratic_drag");
    const diagnose::Diagnosis found = diagnose::diagnose(
        diagnose::specimens_of(recordings), quick_diagnosis("taper,viscous_drag,quadratic_drag"));
    EXPECT_EQ(found.effects, std::vector<std::string>{"quadratic_drag"});
    // Two drags are one law: only the taper is a blind spot.
    ASSERT_EQ(found.detection_limits.size(), 1u);
    EXPECT_EQ(found.detection_limits.front().effect, "taper");
}

} // namespace
} // namespace culm::tests
