// SPDX-License-Identifier: BSD-3-Clause
// Results of items that several ranks computed, brought together.
#pragma once

#include "farm/communicator.hpp"

#include <cstddef>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace culm::cli {

/// Every rank's items, in their order, on rank 0; null where no rank has one. `communicator` is
/// null without a launcher. Collective.
[[nodiscard]] inline nlohmann::json gathered(const std::vector<nlohmann::json>& own,
                                             const farm::Communicator* communicator) {
    nlohmann::json items(own);
    if (communicator == nullptr)
        return items;
    for (const std::string& told : communicator->gather(items.dump())) {
        const nlohmann::json theirs = nlohmann::json::parse(told);
        for (std::size_t k = 0; k < theirs.size(); ++k)
            if (!theirs[k].is_null())
                items[k] = theirs[k];
    }
    return items;
}

} // namespace culm::cli
