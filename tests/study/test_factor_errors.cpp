// SPDX-License-Identifier: BSD-3-Clause
// The exact messages for invalid study files: factors and design.
#include "refused.hpp"

#include <gtest/gtest.h>

namespace culm::study {
namespace {

std::string factor_refusal(const std::string& factor, const std::string& design = "") {
    return refusal("[factors]\n" + factor + "\n" + design);
}

TEST(FactorErrors, UnknownParameterGetsTheNearestName) {
    EXPECT_EQ(factor_refusal("bond_dampin = [1, 2]"),
              "s.toml:2: factors.bond_dampin = [1, 2]: unknown key (did you mean bond_damping?)");
    EXPECT_EQ(factor_refusal("length_m = [0.1]"),
              "s.toml:2: factors.length_m = [0.1]: unknown key: write length_mm, in mm");
}

TEST(FactorErrors, SingleValueBelongsIntoItsSection) {
    EXPECT_EQ(factor_refusal("tip_deflection_mm = 15"),
              "s.toml:2: factors.tip_deflection_mm = 15: must be a list, a range or a "
              "distribution; a single value belongs into [release]");
}

TEST(FactorErrors, EveryLevelMustBeAllowed) {
    EXPECT_EQ(factor_refusal("bond_damping = [\n25,\n-1]"),
              "s.toml:4: factors.bond_damping = -1: must be a number in [0, 100000]");
    EXPECT_EQ(factor_refusal("spheres = [20, 30.5]"),
              "s.toml:2: factors.spheres = 30.5: must be a whole number in [2, 10000]");
    EXPECT_EQ(factor_refusal("bond_damping = [25, 50, 25]"),
              "s.toml:2: factors.bond_damping = [25, 50, 25]: must name 25 once only");
}

TEST(FactorErrors, ParameterMayBeGivenOnceOnly) {
    EXPECT_EQ(
        refusal("[stem]\nbond_damping = 25\n[factors]\nbond_damping = [25, 50]\n"),
        "s.toml:4: factors.bond_damping: may be given once only; it is in [stem] too, line 2");
}

TEST(FactorErrors, RangeNeedsItsEnds) {
    EXPECT_EQ(factor_refusal("bond_damping = { from = 25, step = 5 }"),
              "s.toml:2: factors.bond_damping.to is missing: a range needs it");
    EXPECT_EQ(factor_refusal("bond_damping = { from = 25, to = 5, step = 5 }"),
              "s.toml:2: factors.bond_damping.to = 5: must be greater than from = 25");
    EXPECT_EQ(factor_refusal("bond_damping = { from = -25, to = 5, step = 5 }"),
              "s.toml:2: factors.bond_damping.from = -25: must be a number in [0, 100000]");
}

TEST(FactorErrors, RangeIsDividedByStepOrCount) {
    EXPECT_EQ(factor_refusal("bond_damping = { from = 25, to = 200, step = 30 }"),
              "s.toml:2: factors.bond_damping.step = 30: must divide the range from 25 to 200 into "
              "1 to 1000000 parts");
    EXPECT_EQ(factor_refusal("bond_damping = { from = 25, to = 200, step = 25, count = 8 }"),
              "s.toml:2: factors.bond_damping.step = 25: not together with count");
    EXPECT_EQ(
        factor_refusal("bond_damping = { from = 25, to = 200, step = 25, spacing = \"log\" }"),
        "s.toml:2: factors.bond_damping.step = 25: spacing = \"log\" takes count instead");
    EXPECT_EQ(factor_refusal("bond_damping = { from = 25, to = 200 }"),
              "s.toml:2: factors.bond_damping = { from = 25, to = 200 }: a range in a factorial "
              "design needs step or count");
    EXPECT_EQ(factor_refusal("bond_damping = { from = 0, to = 200, count = 3, spacing = \"log\" }"),
              "s.toml:2: factors.bond_damping.from = 0: must be positive for spacing = \"log\"");
    EXPECT_EQ(factor_refusal("spheres = { from = 10, to = 15, count = 3 }"),
              "s.toml:2: factors.spheres = { from = 10, to = 15, count = 3 }: levels must be whole "
              "numbers");
}

TEST(FactorErrors, DistributionNeedsItsMoments) {
    EXPECT_EQ(factor_refusal("length_mm = { distribution = \"normal\", mean = 156 }"),
              "s.toml:2: factors.length_mm.sd is missing: distribution = \"normal\" needs it");
    EXPECT_EQ(factor_refusal("length_mm = { distribution = \"uniform\", min = 100 }"),
              "s.toml:2: factors.length_mm.max is missing: distribution = \"uniform\" needs it");
    EXPECT_EQ(factor_refusal("length_mm = { distribution = \"normal\", mean = 156, sd = 0 }"),
              "s.toml:2: factors.length_mm.sd = 0: must be a number above 0");
    EXPECT_EQ(factor_refusal("length_mm = { distribution = \"gauss\", mean = 156, sd = 4 }"),
              "s.toml:2: factors.length_mm.distribution = \"gauss\": must be \"normal\", "
              "\"lognormal\", \"uniform\" or \"empirical\"");
    EXPECT_EQ(
        factor_refusal("length_mm = { distribution = \"normal\", mean = 9, sd = 4, step = 1 }"),
        "s.toml:2: factors.length_mm.step = 1: only for a range, without distribution");
    EXPECT_EQ(factor_refusal("bond_damping = { from = 1, to = 2, step = 1, mean = 1 }"),
              "s.toml:2: factors.bond_damping.mean = 1: only with distribution");
}

TEST(FactorErrors, TruncationMustLeaveSomething) {
    EXPECT_EQ(factor_refusal("length_mm = { distribution = \"uniform\", min = 9, max = 5 }"),
              "s.toml:2: factors.length_mm.max = 5: max = 5 must be greater than min = 9");
    EXPECT_EQ(
        factor_refusal("length_mm = { distribution = \"normal\", mean = 156, sd = 4, min = 172 }"),
        "s.toml:2: factors.length_mm.mean = 156: only 3.2e-05 of the distribution lies "
        "between min = 172 and max = 100000; at least 0.001 must");
}

TEST(FactorErrors, WholeNumbersAreNotDrawn) {
    EXPECT_EQ(
        factor_refusal("spheres = { distribution = \"uniform\", min = 5, max = 50 }"),
        "s.toml:2: factors.spheres.distribution = \"uniform\": whole numbers take a list or a "
        "range");
}

TEST(DesignErrors, SampledDesignsNeedPoints) {
    EXPECT_EQ(factor_refusal("bond_damping = [1, 2]", "[design]\ntype = \"sobol\"\n"),
              "s.toml:3: design.points is missing: type = \"sobol\" needs it");
    EXPECT_EQ(factor_refusal("bond_damping = [1, 2]", "[design]\npoints = 5\n"),
              "s.toml:4: design.points = 5: only with type = \"latin_hypercube\" or \"sobol\"");
    EXPECT_EQ(refusal("[design]\ntype = \"sobol\"\npoints = 5\n"),
              "s.toml:2: design.type = \"sobol\": needs at least one factor in [factors]");
}

TEST(DesignErrors, ReplicatesNeedADistribution) {
    EXPECT_EQ(factor_refusal("bond_damping = [1, 2]", "[design]\nreplicates = 5\n"),
              "s.toml:4: design.replicates = 5: must be 1, for no factor is a distribution: every "
              "replicate would repeat the same computation");
}

TEST(DesignErrors, TooManyPointsAreRefused) {
    EXPECT_EQ(
        factor_refusal("bond_damping = { from = 1, to = 100, count = 100000 }\n"
                       "density_kg_m3 = { from = 1, to = 100, count = 100000 }"),
        "s.toml:1: design: 1e+10 points, replicates included; at most 100000000 are possible");
}

TEST(DesignErrors, ListNeedsEqualPoints) {
    const std::string list = "[design]\ntype = \"list\"\n";
    EXPECT_EQ(refusal(list), "s.toml:1: design.point is missing: type = \"list\" needs "
                             "[[design.point]] tables");
    EXPECT_EQ(refusal(list + "[[design.point]]\nbond_damping = 1\n[[design.point]]\nspheres = 9\n"),
              "s.toml:5: design.point.bond_damping is missing: every [[design.point]] must give "
              "what the first gives\n"
              "s.toml:6: design.point.spheres = 9: the first [[design.point]] does not give it");
    EXPECT_EQ(refusal(list + "[[design.point]]\nbond_damping = -1\n"),
              "s.toml:4: design.point.bond_damping = -1: must be a number in [0, 100000]");
    EXPECT_EQ(refusal(list + "[[design.point]]\nbond_damping = 1\n[factors]\nspheres = [9]\n"),
              "s.toml:6: factors.spheres = [9]: must be a distribution; a list design takes other "
              "values from [[design.point]]");
    EXPECT_EQ(refusal("[[design.point]]\nbond_damping = 1\n"),
              "s.toml:1: design.point = [{ bond_damping = 1 }]: only with type = \"list\"");
}

} // namespace
} // namespace culm::study
