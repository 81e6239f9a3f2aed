// SPDX-License-Identifier: BSD-3-Clause
// Items over ranks: the same outcomes in the same order on every rank, for any number of ranks.
#include "core/error.hpp"
#include "farm/item_map.hpp"
#include "farm_fixture.hpp"

#include <cmath>
#include <map>
#include <stdexcept>
#include <thread>

namespace culm::farm {
namespace {

struct Found {
    std::size_t item = 0;
    std::vector<double> values;
    std::optional<std::string> remark;
    friend bool operator==(const Found&, const Found&) = default;
};

Found found_of(std::size_t item) {
    Found found{item, {}, {}};
    for (std::size_t k = 0; k <= item; ++k)
        found.values.push_back(std::sqrt(static_cast<double>(item + k)) / 3.0);
    if (item % 3 == 1)
        found.remark = "item " + std::to_string(item);
    return found;
}

std::vector<double> uneven_costs(std::size_t count) {
    std::vector<double> costs;
    for (std::size_t item = 0; item < count; ++item)
        costs.push_back(static_cast<double>((7 * item) % 5));
    return costs;
}

template <class Function>
auto map(const Communicator* communicator, const std::vector<double>& costs,
         const Function& function, ItemOptions options = {}) {
    return over_ranks(communicator, std::move(options)).outcomes(costs, function);
}

class FarmItems : public FarmTest {};

TEST_F(FarmItems, ReturnInTheirOrderOnEveryRankBitForBit) {
    for (const std::size_t count : {0U, 1U, 2U, 17U}) {
        const auto outcomes = map(&world_, uneven_costs(count),
                                  [](std::size_t item, const core::Heartbeat& heartbeat) {
                                      EXPECT_TRUE(heartbeat());
                                      return found_of(item);
                                  });
        ASSERT_EQ(outcomes.size(), count);
        for (std::size_t item = 0; item < count; ++item)
            EXPECT_EQ(outcomes[item].value, found_of(item)) << "rank " << world_.rank();
    }
}

TEST_F(FarmItems, AreTheSameWithoutACommunicator) {
    const auto outcomes =
        map(nullptr, uneven_costs(5),
            [](std::size_t item, const core::Heartbeat&) { return found_of(item); });
    ASSERT_EQ(outcomes.size(), 5U);
    for (std::size_t item = 0; item < 5; ++item)
        EXPECT_EQ(outcomes[item].value, found_of(item));
}

TEST_F(FarmItems, KeepTheKindOfANumericalFailure) {
    const auto fail = [](std::size_t item, const core::Heartbeat&) {
        if (item == 1)
            throw core::NumericalError(core::FailureKind::StaticFailed, "no equilibrium");
        return found_of(item);
    };
    const auto outcomes = map(&world_, uneven_costs(3), fail);
    EXPECT_TRUE(outcomes[0].value && outcomes[2].value);
    EXPECT_EQ(outcomes[1].failure, "no equilibrium");
    EXPECT_EQ(outcomes[1].kind, core::FailureKind::StaticFailed);
    try {
        static_cast<void>(over_ranks(&world_).values(uneven_costs(3), fail));
        ADD_FAILURE() << "the failure is lost";
    } catch (const core::NumericalError& error) {
        EXPECT_EQ(error.kind(), core::FailureKind::StaticFailed);
        EXPECT_STREQ(error.what(), "no equilibrium");
    }
}

TEST_F(FarmItems, BecomeFailuresAndDoNotHarmOthersWhenTheyThrow) {
    const auto outcomes =
        map(&world_, uneven_costs(9), [](std::size_t item, const core::Heartbeat&) {
            if (item == 4)
                throw core::InputError("the chain leaves the stem");
            return found_of(item);
        });
    for (std::size_t item = 0; item < 9; ++item) {
        EXPECT_EQ(outcomes[item].value.has_value(), item != 4);
        EXPECT_EQ(outcomes[item].failure, item == 4 ? "the chain leaves the stem" : "");
    }
}

TEST_F(FarmItems, ThrowTheSameReasonFromValuesOnEveryRank) {
    const core::ItemMap items = over_ranks(&world_);
    std::string reason;
    try {
        (void)items.values(uneven_costs(6), [](std::size_t item, const core::Heartbeat&) {
            if (item >= 3)
                throw std::logic_error("no answer to " + std::to_string(item));
            return 1.0;
        });
    } catch (const std::runtime_error& error) {
        reason = error.what();
    }
    EXPECT_EQ(reason, "item 3: no answer to 3") << "rank " << world_.rank();
}

TEST_F(FarmItems, EndOnEveryRankWhenOneCannotStore) {
    EXPECT_THROW((void)map(&world_, uneven_costs(4),
                           [](std::size_t item, const core::Heartbeat&) -> double {
                               if (item == 2)
                                   throw core::StorageError("no space left");
                               return 1.0;
                           }),
                 core::StorageError);
}

TEST_F(FarmItems, KeepTheirValueWhenTheyCountAsFailed) {
    Progress last;
    ItemOptions options;
    options.progress = [&last](const Progress& progress) { last = progress; };
    const auto outcomes =
        over_ranks(&world_, options)
            .outcomes(
                uneven_costs(6), [](std::size_t item, const core::Heartbeat&) { return item; },
                [](const std::size_t& item) { return item % 2 == 1; });
    EXPECT_EQ(outcomes[5].value, 5U);
    if (world_.rank() == 0) {
        EXPECT_EQ(last.points_done, 6);
        EXPECT_EQ(last.failed, 3);
    }
}

TEST_F(FarmItems, AreNotComputedAgainIfTheyAreStored) {
    std::map<std::int64_t, core::Bytes> stored; // on rank 0
    ItemOptions options;
    options.store = {{[&stored](std::int64_t number) {
                          const auto found = stored.find(number);
                          return found == stored.end() ? std::nullopt
                                                       : std::optional(found->second);
                      },
                      [&stored](std::int64_t number, const core::Bytes& value) {
                          EXPECT_TRUE(stored.emplace(number, value).second);
                      }}};
    const auto work = [](std::size_t item, const core::Heartbeat&) { return found_of(item); };
    const core::ItemMap items = over_ranks(&world_, options);
    const auto first = items.values(uneven_costs(5), work);
    EXPECT_EQ(items.values(uneven_costs(3), work).size(), 3U);
    if (world_.rank() == 0) {
        EXPECT_EQ(stored.size(), 8U);
        stored.erase(2);
        stored.erase(6); // item 1 of the second call
    }
    std::vector<std::size_t> computed;
    const auto counted = [&computed](std::size_t item, const core::Heartbeat&) {
        computed.push_back(item);
        return found_of(item);
    };
    const core::ItemMap again = over_ranks(&world_, options);
    EXPECT_EQ(again.values(uneven_costs(5), counted), first);
    EXPECT_EQ(again.values(uneven_costs(3), counted).size(), 3U);
    const auto total = world_.gather(std::to_string(computed.size()));
    int sum = 0;
    for (const std::string& each : total)
        sum += std::stoi(each);
    EXPECT_EQ(sum, world_.rank() == 0 ? 2 : 0);
    EXPECT_EQ(stored.size(), world_.rank() == 0 ? 8U : 0U);
}

TEST_F(FarmItems, EndOnEveryRankIfTheStoreIsFull) {
    ItemOptions options;
    options.store = {
        {[](std::int64_t) { return std::optional<core::Bytes>(); },
         [](std::int64_t, const core::Bytes&) { throw core::StorageError("no space left"); }}};
    EXPECT_THROW(
        (void)over_ranks(&world_, options)
            .values(uneven_costs(4), [](std::size_t item, const core::Heartbeat&) { return item; }),
        core::StorageError);
}

TEST_F(FarmItems, ThrowOnEveryRankIfTheyAreStopped) {
    ItemOptions options;
    options.stop_requested = [] { return true; };
    EXPECT_THROW((void)over_ranks(&world_, options)
                     .values(std::vector<double>(20, 1.0),
                             [](std::size_t item, const core::Heartbeat& heartbeat) {
                                 while (heartbeat())
                                     std::this_thread::yield();
                                 if (!heartbeat())
                                     throw std::logic_error("given up");
                                 return item;
                             }),
                 core::MapStopped);
}

TEST_F(FarmItems, SendTheResultOrTheErrorOfRank0ToEveryRank) {
    EXPECT_EQ(on_root(&world_, [] { return found_of(7); }), found_of(7));
    EXPECT_THROW((void)on_root(&world_, []() -> int { throw core::InputError("a wrong key"); }),
                 core::InputError);
    EXPECT_THROW((void)on_root(&world_, []() -> int { throw core::StorageError("full"); }),
                 core::StorageError);
}

} // namespace
} // namespace culm::farm
