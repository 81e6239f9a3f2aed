// SPDX-License-Identifier: BSD-3-Clause
// The bisected limit of the step against the linearised chain, the authors' rule, and similarity.
#include "run/explicit_steps.hpp"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

namespace culm::run {
namespace {

CaseSpec stem_of(double damping, const physics::BondLawOptions& law) {
    CaseSpec spec;
    spec.stem.sphere_count = 12;
    spec.stem.bond_damping = damping;
    spec.law = law;
    spec.tip_deflection = 1e-4; // 0.3 % of the length: axial waves see a straight chain
    return spec;
}

StabilityBracket bracket_of(const CaseSpec& spec, double tolerance = 0.01) {
    return search_stable_step(spec, published_timestep_rule(spec.stem), {tolerance, 20'000});
}

TEST(StabilitySearch, FindsTheLimitOfTheLinearisedChainForBothLaws) {
    for (const auto& law : {physics::schramm2019_law(), physics::consistent_law()})
        for (const double damping : {0.0, 0.3, 1.0, 25.0, 200.0}) {
            const CaseSpec spec = stem_of(damping, law);
            const StabilityBracket found = bracket_of(spec);
            const double predicted = timestep_limits(spec).linearised();
            // The bracket is 1 % wide. Its stable end can be above the limit by 20/20000, since
            // 20000 steps amplify this too little. At this deflection nonlinearity adds less.
            EXPECT_LT(found.stable, 1.002 * predicted) << damping;
            EXPECT_GT(found.unstable, 0.998 * predicted) << damping;
            EXPECT_GT(found.stable, 0.0);
            EXPECT_LE(found.unstable / found.stable, 1.01 * (1 + 1e-12));
        }
}

TEST(StabilitySearch, NarrowsTheBracketAsFarAsAsked) {
    const CaseSpec spec = stem_of(5.0, physics::schramm2019_law());
    const StabilityBracket wide = bracket_of(spec, 0.3);
    const StabilityBracket narrow = bracket_of(spec, 0.002);
    EXPECT_LE(narrow.unstable / narrow.stable, 1.002 * (1 + 1e-12));
    EXPECT_LT(wide.trials, narrow.trials);
    EXPECT_GE(narrow.stable, wide.stable);
    EXPECT_LE(narrow.unstable, wide.unstable);
}

TEST(StabilitySearch, ReachesTheSameLimitFromAnyGuess) {
    const CaseSpec spec = stem_of(5.0, physics::schramm2019_law());
    const double predicted = timestep_limits(spec).linearised();
    for (const double guess : {1e-4, 1.0, 1e4}) {
        const StabilityBracket found = search_stable_step(spec, guess * predicted, {0.01, 20'000});
        EXPECT_NEAR(found.limit() / predicted, 1.0, 0.011); // half a bracket, and some slack
    }
}

TEST(StabilitySearch, LimitFallsWithTheRootOfYoungsModulus) {
    CaseSpec soft = stem_of(5.0, physics::schramm2019_law());
    CaseSpec stiff = soft;
    stiff.stem.bond_youngs_modulus *= 16.0;
    // Only the unit of time changes: the searches make the same decisions up to rounding.
    EXPECT_NEAR(bracket_of(soft).limit() / bracket_of(stiff).limit(), 4.0, 1e-9);
}

TEST(StabilitySearch, WorksInSpace) {
    CaseSpec spec = stem_of(5.0, physics::schramm2019_law());
    spec.dimensions = 3;
    // The spatial chain includes the planar motion; its torsion is slower for solid bonds.
    EXPECT_NEAR(bracket_of(spec).limit() / timestep_limits(spec).linearised(), 1.0, 0.011);
}

TEST(StabilitySearch, StopsWhenAsked) {
    const CaseSpec spec = stem_of(5.0, physics::schramm2019_law());
    EXPECT_THROW((void)search_stable_step(spec, published_timestep_rule(spec.stem), {},
                                          [] { return false; }),
                 Abandoned);
}

TEST(StabilitySearch, FailsIfNoLimitIsWithinReach) {
    const CaseSpec spec = stem_of(5.0, physics::schramm2019_law());
    try {
        (void)search_stable_step(spec, 1e-30, {0.01, 2000});
        ADD_FAILURE() << "found";
    } catch (const core::NumericalError& error) {
        EXPECT_EQ(error.kind(), core::FailureKind::Instability);
        EXPECT_NE(std::string(error.what()).find("even the largest"), std::string::npos)
            << error.what();
    }
}

TEST(TimestepTheory, AxialLimitOfALongChainIsThatOfADampedWave) {
    // The shortest axial wave of an infinite chain: ω² = 4/τ², c = 8β/√2/τ for reduced masses.
    for (const double damping : {0.0, 1.0, 100.0}) {
        CaseSpec spec = stem_of(damping, physics::schramm2019_law());
        spec.stem.sphere_count = 56;
        const double q = std::numbers::sqrt2 * damping;
        const double infinite = (std::sqrt(1 + q * q) - q) * bond_time(spec.stem);
        // 55 bonds with one free end: the largest ω² is 4cos²(π/111)/τ², 8.0e-4 below; with heavy
        // damping the limit is inversely proportional to it.
        EXPECT_NEAR(timestep_limits(spec).axial / infinite, 1.0, 8.1e-4);
        EXPECT_GT(timestep_limits(spec).axial, infinite);
    }
}

TEST(TimestepTheory, TheAuthorsRuleIsSafeForTheirLawAndUnsafeForTheConsistentOne) {
    for (const double damping : {0.0, 1.0, 25.0, 200.0}) {
        const TimestepLimits limits = timestep_limits(stem_of(damping, physics::schramm2019_law()));
        EXPECT_LT(limits.published_rule, 0.95 * limits.linearised()) << damping;
        EXPECT_GT(limits.published_rule, 0.70 * limits.linearised()) << damping;
    }
    const CaseSpec consistent = stem_of(25.0, physics::consistent_law());
    EXPECT_GT(published_timestep_rule(consistent.stem), 1.2 * bracket_of(consistent).unstable);
}

} // namespace
} // namespace culm::run
