// SPDX-License-Identifier: BSD-3-Clause
// How the diagnosis spreads its work over ranks without knowing of them.
#pragma once

#include "run/simulate.hpp"

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

namespace culm::fit {

/// Computes one item; the answer is text, so that it can travel between ranks.
using ItemWork = std::function<std::string(std::size_t item, const run::Heartbeat& heartbeat)>;

/// Calls the work once for each item, `costs` being relative efforts, and hands all answers, in the
/// order of the items, to every rank. Every rank calls it with the same items. An answer is empty
/// if its item was lost with its rank.
using WorkMap =
    std::function<std::vector<std::string>(const std::vector<double>& costs, const ItemWork& work)>;

/// Without ranks.
[[nodiscard]] inline std::vector<std::string> one_after_the_other(const std::vector<double>& costs,
                                                                  const ItemWork& work) {
    std::vector<std::string> answers;
    for (std::size_t item = 0; item < costs.size(); ++item)
        answers.push_back(work(item, {}));
    return answers;
}

} // namespace culm::fit
