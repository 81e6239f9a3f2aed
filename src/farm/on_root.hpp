// SPDX-License-Identifier: BSD-3-Clause
// What only rank 0 does, such as writing files, and every rank must know the outcome of.
#pragma once

#include "farm/communicator.hpp"

#include <functional>
#include <string>

namespace culm::farm {

/// Runs `action` on rank 0 and hands its answer, or the core::InputError or core::StorageError that
/// it throws, to every rank: none waits for a rank that has given up. `communicator` is null
/// without MPI. Collective. Other exceptions are not passed on.
[[nodiscard]] std::string on_root(const Communicator* communicator,
                                  const std::function<std::string()>& action);

} // namespace culm::farm
