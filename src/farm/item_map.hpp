// SPDX-License-Identifier: BSD-3-Clause
// core::ItemMap (core/item_map.hpp) over the ranks of a communicator: every rank gets the outcome
// of every item, in the order of the items.
#pragma once

#include "core/item_map.hpp"
#include "farm/communicator.hpp"
#include "farm/farm.hpp"

#include <cstdint>
#include <functional>
#include <optional>

namespace culm::farm {

/// Keeps the values of items when the program ends before all are computed. The items of all calls
/// of a map are numbered consecutively. Both functions are called on rank 0 and may throw
/// core::StorageError, which every rank throws then.
struct ItemStore {
    std::function<std::optional<core::Bytes>(std::int64_t number)> find;
    std::function<void(std::int64_t number, const core::Bytes& value)> add;
};

/// Options of over_ranks.
struct ItemOptions {
    std::function<bool()> stop_requested{}; ///< FarmOptions::stop_requested; the map then throws
                                            ///< core::MapStopped
    std::optional<Clock::time_point> deadline{};     ///< FarmOptions::deadline
    std::optional<ItemStore> store{};                ///< items that it has are not computed
    std::function<void(const Progress&)> progress{}; ///< called on rank 0; may be empty
    std::chrono::milliseconds progress_interval{1000};
};

/// An ItemMap over the communicator's ranks; null: this process alone, through the same farm. Each
/// of its calls is collective and begins with the costliest item. A core::StorageError on any rank
/// stops all items and is thrown on every rank. `communicator` must outlive the map. Collective.
[[nodiscard]] core::ItemMap over_ranks(const Communicator* communicator, ItemOptions options = {});

} // namespace culm::farm
