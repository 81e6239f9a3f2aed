// SPDX-License-Identifier: BSD-3-Clause
// The message of a refusal.
#pragma once

#include "core/error.hpp"

#include <string>

namespace culm::tests {

/// The message of core::InputError, or "accepted".
template <class Action>
[[nodiscard]] std::string refusal(const Action& action) {
    try {
        action();
    } catch (const core::InputError& error) {
        return error.what();
    }
    return "accepted";
}

} // namespace culm::tests
