// SPDX-License-Identifier: BSD-3-Clause
// farm::map: a function applied to independent items, one by one, over the ranks of a communicator.
//
//     const auto fits = farm::map(communicator, costs, [&](std::size_t item, const auto& heartbeat)
//     {
//         return fit_of(stems[item], heartbeat);
//     });
//
// gives every rank the outcome of every item, in the order of the items: its value, of any type
// that travels (core/wire.hpp), or why there is none. Code without knowledge of ranks takes a
// core::ItemMap (core/item_map.hpp), which over_ranks makes.
#pragma once

#include "core/item_map.hpp"
#include "farm/communicator.hpp"
#include "farm/farm.hpp"

#include <functional>
#include <utility>
#include <vector>

namespace culm::farm {

/// Options of over_ranks.
struct ItemOptions {
    std::function<void(const Progress&)> progress; ///< called on rank 0; may be empty
    std::chrono::milliseconds progress_interval{1000};
    std::chrono::milliseconds silence_until_dead{0}; ///< FarmOptions::silence_until_dead
};

/// An ItemMap over the communicator's ranks; null: this process alone, through the same farm. Each
/// of its calls is collective and begins with the costliest item. The item that a dead rank was
/// computing is lost, the others are not: values travel with the reports, point to point. A
/// core::StorageError on any rank stops all items and is thrown on every rank. `communicator` must
/// outlive the map. Collective.
[[nodiscard]] core::ItemMap over_ranks(const Communicator* communicator, ItemOptions options = {});

/// Outcomes of function(item, heartbeat) for every item (core::ItemMap::outcomes). Collective.
template <class Function>
[[nodiscard]] auto map(const Communicator* communicator, const std::vector<double>& costs,
                       const Function& function, ItemOptions options = {}) {
    return over_ranks(communicator, std::move(options)).outcomes(costs, function);
}

} // namespace culm::farm
