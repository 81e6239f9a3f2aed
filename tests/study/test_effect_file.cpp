// SPDX-License-Identifier: BSD-3-Clause
// Effects from files are used like effects of the library.
#include "core/error.hpp"
#include "study/config/study_effects.hpp"

#include <string>

#include <gtest/gtest.h>

namespace culm::study {
namespace {

const std::string example = std::string(CULM_SOURCE_DIR) + "/config/effects/any_power_drag.toml";

TEST(EffectFile, CombinesWithEffectsOfTheLibrary) {
    const auto effects = effects_from("taper," + example + "(p=1.5)");
    ASSERT_EQ(effects.size(), 2U);
    EXPECT_EQ(effects[1].effect->name, "any_power_drag");
    EXPECT_EQ(physics::to_string(effects[1]), "any_power_drag(p=1.5)");
}

TEST(EffectFile, KeepsTheOrderOfItsParameters) {
    const auto effect = read_effect_file(example);
    const auto parameters = effect->parameters;
    ASSERT_EQ(parameters.size(), 2U);
    EXPECT_EQ(parameters[0].name, "c");
    EXPECT_EQ(parameters[0].default_value, 2e-3);
    EXPECT_EQ(parameters[0].unit, "N/m");
    EXPECT_EQ(parameters[1].name, "p");
    EXPECT_EQ(parameters[1].scale, 0.5);
}

TEST(EffectFile, IsRefusedWithValuesBeyondItsBounds) {
    try {
        static_cast<void>(effects_from(example + "(p=9)"));
        FAIL();
    } catch (const core::InputError& error) {
        EXPECT_STREQ(error.what(), "any_power_drag.p = 9: must be a number from 0.5 to 4");
    }
}

} // namespace
} // namespace culm::study
