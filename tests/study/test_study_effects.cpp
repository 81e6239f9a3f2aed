// SPDX-License-Identifier: BSD-3-Clause
// Studies with effects, and parameters of effects as factors.
#include "refused.hpp"
#include "run/simulate.hpp"
#include "study/execute/plan.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace culm::study {
namespace {

const std::string drag_study = R"toml(
[study]
effects = ["quadratic_drag", "clamp_compliance(stiffness_nm_rad=0.5)"]
[stem]
spheres = 8
[factors]
bond_damping = [5, 10]
"quadratic_drag.drag_coefficient" = [0.5, 1, 2]
)toml";

TEST(StudyEffects, FixedAndSweptValuesReachEveryCase) {
    const Study study = parse_study(drag_study, "s.toml");
    ASSERT_EQ(study.design.point_count(), 6);
    const double swept[] = {0.5, 1.0, 2.0};
    for (std::int64_t point = 0; point < 6; ++point) {
        const run::CaseSpec spec = case_of_point(study.config, study.design, point);
        ASSERT_EQ(spec.effects.size(), 2U);
        EXPECT_EQ(spec.effects[0].effect->name, "quadratic_drag");
        EXPECT_EQ(spec.effects[0].values[0], swept[point % 3]);
        EXPECT_EQ(spec.effects[1].values[0], 0.5);
        EXPECT_EQ(spec.stem.bond_damping, point < 3 ? 5.0 : 10.0);
    }
}

TEST(StudyEffects, PointsOfOneStudyShareLanesAndAgreeWithSingleRuns) {
    Study study = parse_study(drag_study, "s.toml");
    std::vector<run::CaseSpec> specs;
    for (std::int64_t point = 0; point < 6; ++point) {
        specs.push_back(case_of_point(study.config, study.design, point));
        specs.back().duration = 0.01;
        EXPECT_TRUE(run::can_share_lanes(specs.front(), specs.back()));
    }
    const auto together = run::Simulator().simulate_together(specs);
    for (std::size_t k = 0; k < specs.size(); ++k) {
        const auto alone = run::simulate(specs[k]);
        const auto& a = std::get<run::CaseResult>(together[k]).tip_deflection;
        const auto& b = std::get<run::CaseResult>(alone).tip_deflection;
        ASSERT_EQ(a.size(), b.size());
        for (std::size_t i = 0; i < a.size(); ++i) // 15 mm; lanes and double round differently
            ASSERT_NEAR(a[i], b[i], 1e-11) << i;
    }
}

TEST(StudyEffects, ChangeTheIdentityOnlyIfThereAreAny) {
    const StudyConfig with = parse_config(drag_study, "s.toml");
    EXPECT_NE(with.identity().find("effects.clamp_compliance.stiffness_nm_rad = 0.5\n"),
              std::string::npos);
    EXPECT_NE(with.identity().find("factors.quadratic_drag.drag_coefficient = [0.5, 1, 2]\n"),
              std::string::npos);
    EXPECT_EQ(parse_config("[stem]\nspheres = 8\n", "s.toml").identity(),
              parse_config("[study]\neffects = []\n[stem]\nspheres = 8\n", "s.toml").identity());
}

TEST(StudyEffects, AreRefusedWithLineAndNearestName) {
    const std::string unknown = refusal("[study]\neffects = [\"quadratic_drg\"]\n");
    EXPECT_NE(unknown.find("s.toml:2: study.effects:"), std::string::npos) << unknown;
    EXPECT_NE(unknown.find("quadratic_drag"), std::string::npos) << unknown;
    const std::string factor = refusal("[study]\neffects = [\"quadratic_drag\"]\n[factors]\n"
                                       "\"quadratic_drag.drag_coeficient\" = [1, 2]\n");
    EXPECT_NE(factor.find("s.toml:4:"), std::string::npos) << factor;
    EXPECT_NE(factor.find("quadratic_drag.drag_coefficient"), std::string::npos) << factor;
    const std::string bounds = refusal("[study]\neffects = [\"quadratic_drag\"]\n[factors]\n"
                                       "\"quadratic_drag.drag_coefficient\" = [1, -2]\n");
    EXPECT_NE(bounds.find("s.toml:4:"), std::string::npos) << bounds;
    const std::string word = refusal("[study]\neffects = \"quadratic_drag\"\n");
    EXPECT_NE(word.find("must be a list of names"), std::string::npos) << word;
    const std::string kind =
        refusal("[study]\nkind = \"timestep\"\neffects = [\"quadratic_drag\"]\n");
    EXPECT_NE(kind.find("timestep"), std::string::npos) << kind;
}

TEST(StudyEffects, ExplicitStepsAreCheckedWithTheEffects) {
    // A stiff spring at the clamp does not limit the step, but Y and β do, as without effects.
    const std::string text = R"(
[study]
effects = ["clamp_compliance"]
[stem]
spheres = 8
bond_youngs_modulus_gpa = 10
[integrator]
method = "explicit"
timestep_s = 1e-5
)";
    try {
        (void)parse_study(text, "s.toml");
        FAIL() << "a step far above the limit was accepted";
    } catch (const core::InputError& error) {
        EXPECT_NE(std::string(error.what()).find("largest stable step"), std::string::npos)
            << error.what();
    }
}

} // namespace
} // namespace culm::study
