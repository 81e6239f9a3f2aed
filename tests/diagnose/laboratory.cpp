// SPDX-License-Identifier: BSD-3-Clause
#include "beam_generator/recording.hpp"
#include "core/error.hpp"
#include "diagnosis_records.hpp"
#include "physics/effects/selection.hpp"

#include <cmath>
#include <string>
#include <vector>

#include <Eigen/Dense>
#include <gtest/gtest.h>

namespace culm::tests {
namespace {

using diagnose::Conclusion;

/// A linear stem: three own numbers, one shared number and one shared error term.
diagnose::SharedColumns linear_stem(int seed, double at, double term) {
    std::srand(static_cast<unsigned>(seed));
    diagnose::SharedColumns stem;
    stem.system.jacobian = Eigen::MatrixXd::Random(40, 5);
    stem.system.residual = Eigen::VectorXd::Random(40);
    stem.system.ids = {
        {{}, "a", {}}, {{}, "b", {}}, {{}, "c", {}}, {"drag", "c", {}}, {{}, "scale", {}}};
    stem.system.fitted = 4;
    stem.own = {0, 1, 2};
    stem.columns = {3, 4};
    stem.names = {"drag.c of rig A", "scale of rig A"};
    stem.at = {at, term};
    return stem;
}

// One least-squares problem of all stems' own and shared numbers at once.
TEST(SharedMinimum, IsTheLeastSquaresSolutionOfAllStemsTogether) {
    const std::vector<double> variances{1.0, 2.0, 0.5};
    const std::vector<double> terms{0.3, -0.2, 0.1};
    constexpr double at = 0.7;
    constexpr double mean = 0.2;
    constexpr double precision = 5.0;
    std::vector<diagnose::SharedBlock> blocks;
    Eigen::MatrixXd all = Eigen::MatrixXd::Zero(122, 11);
    Eigen::VectorXd right = Eigen::VectorXd::Zero(122);
    for (int s = 0; s < 3; ++s) {
        const auto k = static_cast<std::size_t>(s);
        const diagnose::SharedColumns stem = linear_stem(s, at, terms[k]);
        blocks.push_back(block_of(stem));
        const double weight = 1.0 / std::sqrt(variances[k]);
        all.block(40 * s, 3 * s, 40, 3) = weight * stem.system.jacobian.leftCols(3);
        all.block(40 * s, 9, 40, 2) = weight * stem.system.jacobian.rightCols(2);
        // The residual at the shared numbers' origin.
        right.segment(40 * s, 40) =
            weight * (stem.system.residual +
                      stem.system.jacobian.rightCols(2) * Eigen::Vector2d(at, terms[k]));
    }
    all(120, 9) = std::sqrt(precision);
    right(120) = std::sqrt(precision) * mean;
    all(121, 10) = 1.0;
    const diagnose::SharedMinimum found =
        minimum_of(blocks, variances, {{"drag.c of rig A", {mean, precision}}});
    const Eigen::VectorXd expected = all.colPivHouseholderQr().solve(right);
    ASSERT_EQ(found.names.size(), 2u);
    EXPECT_NEAR(found.at(0), expected(9), 1e-10);
    EXPECT_NEAR(found.at(1), expected(10), 1e-10);
    const Eigen::MatrixXd covariance = (all.transpose() * all).inverse();
    EXPECT_NEAR(found.hessian.inverse()(0, 0), covariance(9, 9), 1e-10);
    // The own numbers follow.
    const Eigen::MatrixXd follow = blocks[0].follow;
    EXPECT_EQ(follow(3, 0), 1.0); // the shared number itself
    const Eigen::VectorXd own = linear_stem(0, at, terms[0])
                                    .system.jacobian.leftCols(3)
                                    .colPivHouseholderQr()
                                    .solve(linear_stem(0, at, terms[0]).system.residual);
    for (Eigen::Index k = 0; k < 3; ++k)
        EXPECT_NEAR(own(k) + follow(k, 0) * (found.at(0) - at) +
                        follow(k, 1) * (found.at(1) - terms[0]),
                    expected(k), 1e-9);
}

TEST(SharedMinimum, StaysWithinTheBounds) {
    const std::vector<diagnose::SharedBlock> blocks{block_of(linear_stem(1, 0.0, 0.0))};
    const std::vector<double> variances{1.0};
    const double free = minimum_of(blocks, variances, {}).at(0);
    const double bound = free > 0.0 ? 0.5 * free : -1e-3;
    diagnose::SharedPrior prior;
    prior.upper = bound;
    EXPECT_DOUBLE_EQ(minimum_of(blocks, variances, {{"drag.c of rig A", prior}}).at(0),
                     std::min(free, bound));
}

TEST(Presence, IsAProbabilityOverAllSetsWithAStem) {
    constexpr std::size_t stems = 12;
    double sum = 0.0;
    double choices = 1.0;
    for (std::size_t with = 0; with <= stems; ++with) {
        sum += with > 0 ? choices * std::exp(diagnose::log_presence(with, stems)) : 0.0;
        choices *= static_cast<double>(stems - with) / static_cast<double>(with + 1);
    }
    EXPECT_NEAR(sum, 1.0, 1e-12);
    EXPECT_NEAR(diagnose::log_presence(1, 1), 0.0, 1e-12);
}

TEST(Presence, IsCertainWhereTheReadingsAre) {
    const std::vector<double> gains{30.0, -2.0, -2.0, -2.0, -2.0, -2.0};
    const std::vector<double> found = diagnose::presence_of(gains);
    EXPECT_GT(found.front(), 0.99);
    EXPECT_LT(found.back(), 0.1);
}

/// A stem whose material and size depend on its number.
beam::RecordingSpec stem_of_laboratory(int number, double drag) {
    beam::RecordingSpec spec;
    spec.id = "L" + std::to_string(number);
    spec.stem.length = 0.150 + 0.004 * number;
    spec.stem.diameter = (2.6 + 0.1 * number) * 1e-3;
    spec.stem.youngs_modulus = (2.0 + 0.3 * number) * 1e9;
    spec.heights = beam::even_heights(spec.stem.length, 6);
    spec.duration = 0.25;
    spec.errors.noise = 0.1e-3;
    spec.seed = 10 + static_cast<std::uint64_t>(number);
    if (drag > 0.0)
        spec.effects = {{"quadratic_drag", {{"drag_coefficient", drag}}}};
    return spec;
}

std::vector<diagnose::Specimen> laboratory(std::vector<beam::RecordingSpec> specs) {
    std::vector<measure::Measurement> recordings;
    for (const beam::RecordingSpec& spec : specs) {
        recordings.push_back(beam::record(spec));
        recordings.back().rig = "A";
    }
    return diagnose::specimens_of(recordings);
}

TEST(Specimens, AreTheRecordingsUnlessTheyNameOne) {
    std::vector<measure::Measurement> recordings(3);
    recordings[0].stem.id = "a";
    recordings[1].stem.id = "b";
    recordings[2].stem.id = "c";
    recordings[2].specimen = "a";
    const std::vector<diagnose::Specimen> found = diagnose::specimens_of(recordings);
    ASSERT_EQ(found.size(), 2u);
    EXPECT_EQ(found[0].recordings.size(), 2u);
    EXPECT_EQ(found[1].name, "b");
    recordings[2].rig = "B";
    EXPECT_THROW(static_cast<void>(diagnose::specimens_of(recordings)), core::InputError);
}

TEST(Laboratory, SharesTheDragOfARigAndFindsTheMassOfOneStem) {
    constexpr double drag = 1.1;
    std::vector<beam::RecordingSpec> specs;
    for (int k = 0; k < 4; ++k)
        specs.push_back(stem_of_laboratory(k, drag));
    const double mass = 0.5 * specs[2].stem.mass_per_length() * specs[2].stem.length;
    specs[2].effects.push_back({"tip_mass", {{"mass_kg", mass}}});
    diagnose::DiagnosisOptions options = quick_diagnosis("quadratic_drag,tip_mass");
    options.candidate.chain.spheres = 24;
    const std::vector<diagnose::Specimen> stems = laboratory(specs);
    const diagnose::Diagnosis found = diagnose::diagnose(stems, options);
    EXPECT_EQ(found.conclusion, Conclusion::Effect) << found.reason;
    ASSERT_EQ(found.answers.size(), 2u);
    const diagnose::EffectAnswer& shared = found.answers.front();
    EXPECT_EQ(shared.effect, "quadratic_drag");
    EXPECT_EQ(shared.rig, "A");
    EXPECT_GT(shared.probability, 0.95);
    const diagnose::SharedValue& value = shared.values.front();
    EXPECT_LT(value.lower, drag);
    EXPECT_GT(value.upper, drag);
    EXPECT_LT(value.upper - value.lower, 0.3 * drag);
    EXPECT_EQ(found.answers.back().effect, "tip_mass");
    EXPECT_EQ(found.answers.back().stems, (std::vector<std::string>{"L2"}));
    EXPECT_TRUE(found.answers.back().possible_stems.empty());
    ASSERT_EQ(found.stems[2].own_values.size(), 1u);
    const fit::FittedParameter& own = found.stems[2].own_values.front();
    EXPECT_NEAR(own.value, mass, 3.0 * own.standard_error);
    EXPECT_LT(own.standard_error, 0.2 * mass);
    for (const diagnose::StemAnswer& stem : found.stems) {
        EXPECT_TRUE(stem.failure.empty()) << stem.failure;
        EXPECT_LT(stem.after.over_noise, 1.1);
    }
}

// The laws of drag share the probability; the family is certain, and its second law is no second
// effect.
TEST(Laboratory, NamesACertainFamilyOnce) {
    std::vector<beam::RecordingSpec> specs;
    for (int k = 0; k < 3; ++k)
        specs.push_back(stem_of_laboratory(k, 1.1));
    diagnose::DiagnosisOptions options = quick_diagnosis("quadratic_drag,viscous_drag,power_drag");
    const std::vector<diagnose::Specimen> stems = laboratory(specs);
    const diagnose::Diagnosis found = diagnose::diagnose(stems, options);
    EXPECT_EQ(found.conclusion, Conclusion::Effect) << found.reason;
    ASSERT_EQ(found.families.size(), 1u);
    EXPECT_EQ(found.families.front().family, physics::Family::Air);
    EXPECT_EQ(found.families.front().rig, "A");
    EXPECT_TRUE(found.families.front().is_open);
}

TEST(Laboratory, NamesNothingWhereTheChainIsRight) {
    std::vector<beam::RecordingSpec> specs;
    for (int k = 0; k < 4; ++k)
        specs.push_back(stem_of_laboratory(k, 0.0));
    diagnose::DiagnosisOptions options = quick_diagnosis("quadratic_drag,clamp_compliance,taper");
    options.candidate.chain.spheres = 24;
    const std::vector<diagnose::Specimen> stems = laboratory(specs);
    const diagnose::Diagnosis found = diagnose::diagnose(stems, options);
    EXPECT_EQ(found.conclusion, Conclusion::Adequate) << found.reason;
    EXPECT_GE(found.probability, 0.95);
    EXPECT_TRUE(found.families.empty());
    for (const diagnose::EffectAnswer& each : found.answers)
        EXPECT_TRUE(each.values.empty()) << each.effect;
    EXPECT_EQ(found.detection_limits.size(), 2u); // of the rig's candidates
    for (const diagnose::DetectionLimit& limit : found.detection_limits)
        EXPECT_NE(limit.of_one, limit.value);
}

TEST(Laboratory, DoesNotNameWhatIsKnown) {
    std::vector<beam::RecordingSpec> specs{stem_of_laboratory(0, 1.1), stem_of_laboratory(1, 1.1)};
    diagnose::DiagnosisOptions options = quick_diagnosis("clamp_compliance");
    options.candidate.chain.spheres = 24;
    options.known = physics::parse_effects("quadratic_drag", {});
    const std::vector<diagnose::Specimen> stems = laboratory(specs);
    const diagnose::Diagnosis found = diagnose::diagnose(stems, options);
    EXPECT_EQ(found.conclusion, Conclusion::Adequate) << found.reason;
    ASSERT_FALSE(found.answers.empty());
    EXPECT_TRUE(found.answers.front().is_known);
    EXPECT_NEAR(found.answers.front().values.front().value, 1.1, 0.3);
}

} // namespace
} // namespace culm::tests
