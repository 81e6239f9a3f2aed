// SPDX-License-Identifier: BSD-3-Clause
// The members of a struct are counted and named, whatever their types are.
#include "core/aggregate.hpp"

#include <array>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

namespace culm::core {
namespace {

enum class Colour { Green, Yellow };

struct Empty {};

struct Leaf {
    double length = 0.0;
    std::array<double, 3> tip{};
};

template <class Member>
struct One {
    Member first{};
};

template <class Member>
struct Three {
    std::optional<Member> first;
    const Member second{};
    Member third{};
};

/// Is each of these counted as one member, alone and beside others?
template <class... Members>
constexpr bool are_counted = ((member_count<One<Members>>() == 1 &&
                               member_count<Three<Members>>() == 3 && !has_base<One<Members>> &&
                               !has_base<Three<Members>>)&&...);

static_assert(member_count<Empty>() == 0);
static_assert(are_counted<bool, int, double, Colour, Empty, Leaf, One<int>, One<Leaf>>);
static_assert(are_counted<std::string, std::vector<double>, std::vector<bool>, std::vector<Leaf>,
                          std::map<std::string, double>, std::pair<std::string, bool>>);
static_assert(are_counted<std::array<double, 3>, std::array<Leaf, 2>, std::array<std::string, 1>>);
static_assert(are_counted<std::optional<double>, std::optional<Leaf>, std::optional<std::string>,
                          std::shared_ptr<const Leaf>>);
static_assert(member_count<One<std::unique_ptr<Leaf>>>() == 1);

struct LongLeaf : Leaf {
    int veins = 0;
};
struct MarkedLeaf : Empty {
    int veins = 0;
};
static_assert(has_base<LongLeaf> && has_base<MarkedLeaf> && !has_base<Leaf>);

struct Twelve {
    int a = 1, b = 2, c = 3, d = 4, e = 5, f = 6, g = 7, h = 8, i = 9, j = 10, k = 11, l = 12;
};

TEST(Aggregate, NamesUpToTwelveMembersInTheirOrder) {
    std::vector<int> seen;
    const auto keep = [&](const auto&... members) { (seen.push_back(members), ...); };
    const Empty empty;
    with_members(empty, keep);
    EXPECT_TRUE(seen.empty());
    const Twelve twelve;
    with_members(twelve, keep);
    ASSERT_EQ(seen.size(), 12U);
    for (int k = 0; k < 12; ++k)
        EXPECT_EQ(seen[std::size_t(k)], k + 1);
}

TEST(Aggregate, LetsTheFunctionChangeTheMembers) {
    Leaf leaf;
    with_members(leaf, [](double& length, std::array<double, 3>& tip) {
        length = 0.2;
        tip[1] = 0.1;
    });
    EXPECT_EQ(leaf.length, 0.2);
    EXPECT_EQ(leaf.tip[1], 0.1);
}

} // namespace
} // namespace culm::core
