// SPDX-License-Identifier: BSD-3-Clause
#include "core/nearest_name.hpp"

#include <vector>

#include <gtest/gtest.h>

namespace culm::core {
namespace {

TEST(EditDistance, CountsInsertionsDeletionsAndSubstitutions) {
    EXPECT_EQ(edit_distance("", "abc"), 3U);
    EXPECT_EQ(edit_distance("kitten", "sitting"), 3U);
    EXPECT_EQ(edit_distance("beta", "beta"), 0U);
}

TEST(NearestName, FindsAMistypedName) {
    const std::vector<std::string> valid{"quadratic_drag", "viscous_drag", "gravity"};
    EXPECT_EQ(nearest_name("quadratic_darg", valid), "quadratic_drag");
    EXPECT_EQ(nearest_name("gravty", valid), "gravity");
}

TEST(NearestName, FindsAWordOfALongerName) {
    const std::vector<std::string> valid{"clamp_friction", "quadratic_drag", "viscous_drag"};
    EXPECT_EQ(nearest_name("drag", valid), "quadratic_drag");
    EXPECT_EQ(nearest_name("friction", valid), "clamp_friction");
    EXPECT_EQ(nearest_name("rag", valid), "");
}

TEST(NearestName, FindsASynonymOnlyWhereItsNameIsValid) {
    const std::vector<std::string> designs{"factorial", "latin_hypercube", "sobol", "list"};
    EXPECT_EQ(nearest_name("lhs", designs), "latin_hypercube");
    const std::vector<std::string> parameters{"bond_youngs_modulus_gpa", "bond_damping"};
    EXPECT_EQ(nearest_name("beta", parameters), "bond_damping");
    EXPECT_EQ(nearest_name("beta", designs), "");
}

TEST(NearestName, GivesNothingWhenNoNameIsNear) {
    const std::vector<std::string> valid{"quadratic_drag", "gravity"};
    EXPECT_EQ(nearest_name("xyz", valid), "");
    EXPECT_EQ(nearest_name("anything", {}), "");
}

} // namespace
} // namespace culm::core
