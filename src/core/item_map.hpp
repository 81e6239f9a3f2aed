// SPDX-License-Identifier: BSD-3-Clause
// Applies a function to independent items, on any rank: code that has items to compute takes an
// ItemMap and needs no knowledge of ranks.
//
//     std::vector<Fit> fits =
//         map.values(costs, [&](std::size_t item, const core::Heartbeat& heartbeat) {
//             return fit_of(candidates[item], heartbeat);
//         });
//
// A default ItemMap computes items one by one in this process; farm::over_ranks (farm/item_map.hpp)
// distributes them over ranks. The result of an item is any type that travels (core/wire.hpp).
// Both use the same bytes, so their results are the same, bit for bit.
#pragma once

#include "core/error.hpp"
#include "core/wire.hpp"

#include <cstddef>
#include <exception>
#include <functional>
#include <optional>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace culm::core {

/// Called about every millisecond of work; false: a stop was requested. May be empty.
using Heartbeat = std::function<bool()>;

/// Outcome of an item.
template <class T>
struct ItemOutcome {
    std::optional<T> value;
    std::string failure = {}; ///< why there is no value: the text of an exception
    /// Of a NumericalError; empty: any other exception.
    std::optional<FailureKind> kind = {};
};

/// Thrown by a map, on every rank, if a stop was requested before all items were computed.
struct MapStopped {};

class ItemMap {
  public:
    struct EncodedValue {
        Bytes bytes;
        bool counts_as_failed = false; ///< in what the map reports of its progress
    };
    using EncodedWork = std::function<EncodedValue(std::size_t item, const Heartbeat& heartbeat)>;
    /// Calls the work once for every item, with its relative efforts, and gives all outcomes in the
    /// order of the items to every rank. Every rank calls it with the same items.
    using Spread = std::function<std::vector<ItemOutcome<Bytes>>(const std::vector<double>& costs,
                                                                 const EncodedWork& work)>;

    /// In this process, one item after the other.
    ItemMap() = default;
    explicit ItemMap(Spread spread) : spread_(std::move(spread)) {}

    /// Outcomes of function(item, heartbeat) for the items 0 … costs.size() − 1, in their order, on
    /// every rank. `costs`: relative efforts; the longest items are computed first. `has_failed`
    /// states whether progress counts a value as a failure. An exception of an item is an outcome,
    /// but a StorageError ends the map.
    template <class Function,
              class T = std::invoke_result_t<Function, std::size_t, const Heartbeat&>>
    [[nodiscard]] std::vector<ItemOutcome<T>>
    outcomes(const std::vector<double>& costs, const Function& function,
             const std::type_identity_t<std::function<bool(const T&)>>& has_failed = {}) const {
        const EncodedWork work = [&](std::size_t item, const Heartbeat& heartbeat) -> EncodedValue {
            try {
                const ItemOutcome<T> outcome{function(item, heartbeat)};
                return {encoded(outcome), has_failed && has_failed(*outcome.value)};
            } catch (const NumericalError& error) { // the same on every rank: it travels
                return {encoded(ItemOutcome<T>{std::nullopt, error.what(), error.kind()}), true};
            }
        };
        std::vector<ItemOutcome<T>> found;
        for (ItemOutcome<Bytes>& item : spread_ ? spread_(costs, work) : in_turn(costs, work))
            found.push_back(item.value ? decoded<ItemOutcome<T>>(*std::move(item.value))
                                       : ItemOutcome<T>{std::nullopt, std::move(item.failure), {}});
        return found;
    }

    /// The values alone. Throws, on every rank, the reason of the first item that failed: its
    /// NumericalError, or a std::runtime_error.
    template <class Function,
              class T = std::invoke_result_t<Function, std::size_t, const Heartbeat&>>
    [[nodiscard]] std::vector<T> values(const std::vector<double>& costs,
                                        const Function& function) const {
        std::vector<T> found;
        for (ItemOutcome<T>& item : outcomes(costs, function)) {
            if (!item.value && item.kind)
                throw NumericalError(*item.kind, item.failure);
            if (!item.value)
                throw std::runtime_error("item " + std::to_string(found.size()) + ": " +
                                         item.failure);
            found.push_back(*std::move(item.value));
        }
        return found;
    }

  private:
    static std::vector<ItemOutcome<Bytes>> in_turn(const std::vector<double>& costs,
                                                   const EncodedWork& work) {
        std::vector<ItemOutcome<Bytes>> found(costs.size());
        for (std::size_t item = 0; item < costs.size(); ++item)
            try {
                found[item].value = work(item, {}).bytes;
            } catch (const StorageError&) {
                throw; // as on several ranks: no further result could be stored
            } catch (const std::exception& error) {
                found[item].failure = error.what();
            }
        return found;
    }

    Spread spread_;
};

} // namespace culm::core
