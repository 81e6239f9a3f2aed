// SPDX-License-Identifier: BSD-3-Clause
// A diagnosis's work spread over the ranks of a launcher.
#pragma once

#include "farm/communicator.hpp"
#include "farm/summary.hpp"
#include "fit/work_map.hpp"

#include <functional>

namespace culm::cli {

/// A WorkMap over the communicator's ranks; null: this process alone, through the same farm. Every
/// call is collective. An item that throws makes every rank throw std::runtime_error with its
/// reason; work that reports its failures as text does not. `progress` is called on rank 0.
/// `communicator` must outlive the map.
[[nodiscard]] fit::WorkMap work_over_ranks(const farm::Communicator* communicator,
                                           std::function<void(const farm::Progress&)> progress);

} // namespace culm::cli
