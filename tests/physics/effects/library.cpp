// SPDX-License-Identifier: BSD-3-Clause
// Properties of every effect of the library; how effects are named and combined.
#include "physics/effects/library.hpp"

#include "core/error.hpp"
#include "effect_bench.hpp"
#include "physics/effects/selection.hpp"

#include <algorithm>
#include <set>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace culm::physics {
namespace {

using testing::HasSubstr;

std::string refusal(const auto& action) {
    try {
        action();
    } catch (const core::InputError& error) {
        return error.what();
    }
    return "";
}

EffectPointer no_files(const std::string& file) {
    throw core::InputError(file + ": cannot be read");
}

std::string refusal_of(const char* effects) {
    return refusal([effects] { static_cast<void>(parse_effects(effects, no_files)); });
}

TEST(Library, HasTheEffectsOfTheDesign) {
    const std::set<std::string> wanted{"quadratic_drag",     "viscous_drag",
                                       "power_drag",         "gravity",
                                       "tip_mass",           "clamp_compliance",
                                       "clamp_friction",     "bending_nonlinearity",
                                       "hysteretic_damping", "taper",
                                       "stiffness_gradient", "local_defect",
                                       "precurvature",       "relaxation",
                                       "out_of_plane",       "base_motion",
                                       "finite_release",     "rolling_shutter",
                                       "camera_tilt",        "fractional_zener",
                                       "plate_air",          "still_air",
                                       "clamp_slip",         "amplitude_damping"};
    const std::vector<std::string> names = effect_names();
    EXPECT_EQ(std::set<std::string>(names.begin(), names.end()), wanted);
    EXPECT_EQ(names.size(), wanted.size());
}

TEST(Library, EveryEffectSaysWhatItIsWhatOneSeesAndWhatToDo) {
    for (const EffectPointer& effect : all_effects()) {
        for (const std::string& text : {effect->summary, effect->law, effect->source,
                                        effect->signature, effect->remedy, effect->energy})
            EXPECT_GT(text.size(), 15U) << effect->name << ": " << text;
        EXPECT_NE(effect->summary.back(), '.') << effect->name;
        EXPECT_FALSE(effect->parameters.empty()) << effect->name;
        EXPECT_NE(effect->family, Family::Own) << effect->name;
    }
}

void expect_sound(const Effect& effect, const EffectParameter& parameter) {
    const std::string name = effect.name + "." + parameter.name;
    EXPECT_LT(parameter.lower, parameter.upper) << name;
    EXPECT_GE(parameter.default_value, parameter.lower) << name;
    EXPECT_LE(parameter.default_value, parameter.upper) << name;
    EXPECT_GT(parameter.scale, 0.0) << name;
    EXPECT_FALSE(parameter.meaning.empty()) << name;
    EXPECT_TRUE(parameter.fitted_as == FittedAs::Itself || parameter.lower > 0.0) << name;
}

TEST(Library, DefaultsLieWithinTheirBoundsAndNamesAreUnique) {
    for (const EffectPointer& effect : all_effects()) {
        std::set<std::string> names;
        for (const EffectParameter& parameter : effect->parameters) {
            expect_sound(*effect, parameter);
            EXPECT_TRUE(names.insert(parameter.name).second) << parameter.name;
        }
    }
}

TEST(Library, ParametersThatSuitAStemLieWithinThoseForAllStems) {
    StemParameters<double> silicone;
    silicone.sphere_count = 41;
    silicone.sphere_diameter = silicone.bond_length = 0.025;
    silicone.bond_outer_diameter = 0.03;
    silicone.density = 1000.0;
    silicone.bond_youngs_modulus = 2e5;
    StemParameters<double> hair;
    hair.sphere_diameter = hair.bond_length = hair.bond_outer_diameter = 1e-4;
    for (const auto& stem : {StemParameters<double>{}, silicone, hair})
        for (const EffectPointer& effect : all_effects()) {
            const auto suited = effect->parameters_for(stem);
            const auto parameters = effect->parameters;
            ASSERT_EQ(suited.size(), parameters.size());
            for (std::size_t k = 0; k < suited.size(); ++k) {
                expect_sound(*effect, suited[k]);
                EXPECT_EQ(suited[k].name, parameters[k].name);
                EXPECT_GE(suited[k].lower, parameters[k].lower) << suited[k].name;
                EXPECT_LE(suited[k].upper, parameters[k].upper) << suited[k].name;
            }
        }
}

TEST(Library, EveryEffectChangesTheModelOrTheCamera) {
    const EffectBench none({});
    ASSERT_TRUE(none.model.is_plain());
    for (const EffectPointer& effect : all_effects()) {
        const SelectedEffect selected{
            effect, std::vector<std::optional<double>>(effect->parameters.size())};
        StemParameters<double> strip;
        strip.rectangle_depth = 1e-3;
        const EffectBench bench({with_defaults(selected, strip)}, 56, strip);
        const bool has_weight = bench.model.gravity[0] != 0.0;
        EXPECT_TRUE(!bench.model.is_plain() || has_weight || bench.camera != none.camera)
            << effect->name;
    }
}

TEST(Library, SuggestsTheNearestNameForAMistypedOne) {
    EXPECT_EQ(refusal([] { static_cast<void>(effect_named("quadratic_darg")); }),
              "there is no effect \"quadratic_darg\" (did you mean \"quadratic_drag\"?); `culm "
              "effects` lists those there are");
}

TEST(Combination, RefusesFrictionWithItsOwnSpringInEitherOrder) {
    const std::string text = "effects clamp_friction and clamp_compliance cannot be combined: "
                             "clamp_friction contains clamp_compliance; leave clamp_compliance out";
    EXPECT_EQ(refusal_of("clamp_friction,clamp_compliance"), text);
    EXPECT_EQ(refusal_of("clamp_compliance,clamp_friction"), text);
}

TEST(Combination, RefusesAnEffectThatIsNamedTwice) {
    EXPECT_EQ(refusal_of("gravity,taper,gravity"), "effect gravity is named twice; once is enough");
}

TEST(Combination, DoesNotDependOnTheOrderOfTheNames) {
    const std::vector<ActiveEffect> effects{active("precurvature", {0.2, 0.1}),
                                            active("tip_mass", {1e-5}), active("taper", {-0.3}),
                                            active("stiffness_gradient", {0.4})};
    const EffectBench forward(effects);
    const EffectBench backward(std::vector<ActiveEffect>(effects.rbegin(), effects.rend()));
    for (std::size_t j = 0; j < 55; ++j) {
        EXPECT_EQ(forward.model.straight_moments[j], backward.model.straight_moments[j]);
        EXPECT_EQ(forward.model.bonds[j].bending_damping, backward.model.bonds[j].bending_damping);
    }
    EXPECT_EQ(forward.mass(), backward.mass());
}

TEST(Selection, ReadsNamesAndFixedValues) {
    const auto effects =
        parse_effects(" quadratic_drag , clamp_friction(moment_nm=3e-4, stiffness_nm_rad = 0.8),"
                      "taper()",
                      no_files);
    ASSERT_EQ(effects.size(), 3U);
    EXPECT_EQ(to_string(effects[0]), "quadratic_drag");
    EXPECT_EQ(to_string(effects[1]), "clamp_friction(moment_nm=0.0003,stiffness_nm_rad=0.8)");
    EXPECT_EQ(to_string(effects[2]), "taper");
    EXPECT_TRUE(parse_effects("  ", no_files).empty());
    const ActiveEffect friction = with_defaults(effects[1], StemParameters<double>{});
    EXPECT_EQ(friction.values, (std::vector<double>{3e-4, 0.8, 0.05}));
}

TEST(Selection, AlternativesNeedNotGoTogether) {
    const std::string both = "clamp_friction,clamp_compliance(stiffness_nm_rad=2)";
    EXPECT_THROW(static_cast<void>(parse_effects(both, no_files)), core::InputError);
    const auto alternatives = parse_alternatives(both, no_files);
    ASSERT_EQ(alternatives.size(), 2U);
    EXPECT_EQ(to_string(alternatives[0]), "clamp_friction");
    EXPECT_EQ(to_string(alternatives[1]), "clamp_compliance(stiffness_nm_rad=2)");
    EXPECT_TRUE(parse_alternatives("  ", no_files).empty());
}

TEST(Selection, SaysWhatIsWrong) {
    EXPECT_EQ(refusal_of("quadratic_drag(drag_coefficent=1)"),
              "quadratic_drag has no parameter \"drag_coefficent\" (did you mean "
              "\"drag_coefficient\"?); it has drag_coefficient");
    EXPECT_EQ(refusal_of("quadratic_drag(drag_coefficient=-1)"),
              "quadratic_drag.drag_coefficient = -1: must be a number from 0 to 100");
    EXPECT_EQ(refusal_of("tip_mass(mass_kg=nan)"),
              "tip_mass.mass_kg = nan: must be a number from 0 to 10 kg");
    const std::string hint = "; write for example quadratic_drag(drag_coefficient=1.2)";
    EXPECT_EQ(refusal_of("taper(relative_change=x)"),
              "effect \"taper(relative_change=x)\": \"x\" is not a number" + hint);
    EXPECT_EQ(refusal_of("taper(0.1)"),
              "effect \"taper(0.1)\": \"0.1\" is not parameter=value" + hint);
    EXPECT_EQ(refusal_of("taper(relative_change=0.1"),
              "effect \"taper(relative_change=0.1\": must end with the closing parenthesis" + hint);
    EXPECT_EQ(refusal_of("taper(relative_change=0.1,relative_change=0.2)"),
              "effect \"taper(relative_change=0.1,relative_change=0.2)\": relative_change is given "
              "twice" +
                  hint);
    EXPECT_EQ(refusal_of("taper,,gravity"), "effect \"\": no name" + hint);
    EXPECT_EQ(refusal_of("./mine.toml"), "./mine.toml: cannot be read");
}

} // namespace
} // namespace culm::physics
