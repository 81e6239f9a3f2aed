// SPDX-License-Identifier: BSD-3-Clause
// The error of the farm layer: communication failed, or the farm was called wrongly.
#pragma once

#include <stdexcept>

namespace culm::farm {

/// An MPI call failed, a message could not be understood, or a precondition of the farm is
/// violated.
class FarmError : public std::runtime_error {
  public:
    using std::runtime_error::runtime_error;
};

} // namespace culm::farm
