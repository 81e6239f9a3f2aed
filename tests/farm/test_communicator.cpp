// SPDX-License-Identifier: BSD-3-Clause
// Collective helpers give the right result on every rank, for any root and any length.
#include "farm/batch.hpp"
#include "farm/communicator.hpp"
#include "farm/environment.hpp"

#include <gtest/gtest.h>

namespace culm::farm {
namespace {

TEST(Communicator, BroadcastsTextsOfAnyLengthFromAnyRoot) {
    const Communicator world = Communicator::world();
    for (int root = 0; root < world.size(); ++root)
        for (const std::size_t length : {0U, 1U, 100000U}) {
            const std::string text(length, static_cast<char>('a' + root));
            EXPECT_EQ(world.broadcast(world.rank() == root ? text : "other", root), text);
        }
}

TEST(Communicator, BroadcastsBytesThatIncludeZeros) {
    const Communicator world = Communicator::world();
    const Bytes bytes = {std::byte{1}, std::byte{0}, std::byte{255}};
    EXPECT_EQ(world.broadcast(world.rank() == 0 ? bytes : Bytes()), bytes);
}

TEST(Communicator, GathersTextsOfDifferentLengthsInTheOrderOfRanks) {
    const Communicator world = Communicator::world();
    const int root = world.size() - 1;
    const std::vector<std::string> texts =
        world.gather(std::string(static_cast<std::size_t>(world.rank()), 'x'), root);
    if (world.rank() != root) {
        EXPECT_TRUE(texts.empty());
        return;
    }
    ASSERT_EQ(texts.size(), static_cast<std::size_t>(world.size()));
    for (std::size_t rank = 0; rank < texts.size(); ++rank)
        EXPECT_EQ(texts[rank], std::string(rank, 'x'));
}

TEST(Communicator, IsTrueAnywhereIfOneRankSaysSo) {
    const Communicator world = Communicator::world();
    EXPECT_TRUE(world.is_true_anywhere(world.rank() == world.size() - 1));
    EXPECT_FALSE(world.is_true_anywhere(false));
}

TEST(Communicator, HasTheSameRanksAsItsDuplicate) {
    const Communicator world = Communicator::world();
    const Communicator other = world.duplicate();
    EXPECT_EQ(other.rank(), world.rank());
    EXPECT_EQ(other.size(), world.size());
    other.barrier();
}

TEST(Communicator, ReportsAnInvalidRootWithTheNameOfTheCall) {
    const Communicator world = Communicator::world();
    try {
        (void)world.broadcast(std::string("x"), world.size());
        ADD_FAILURE() << "no error";
    } catch (const FarmError& error) {
        EXPECT_EQ(std::string(error.what()).substr(0, 11), "MPI_Bcast: ");
    }
}

TEST(Environment, ExistsOnlyOnce) {
    int argc = 0;
    char** argv = nullptr;
    EXPECT_THROW(Environment(argc, argv), FarmError);
}

} // namespace
} // namespace culm::farm
