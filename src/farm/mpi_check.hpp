// SPDX-License-Identifier: BSD-3-Clause
// Turns the return codes of MPI into exceptions; for the sources of this layer only.
#pragma once

#include "farm/farm_error.hpp"

#include <array>
#include <string>

#include <mpi.h>

namespace culm::farm {

/// Throws FarmError with MPI's own text if `code` is not MPI_SUCCESS. `call` names the MPI
/// function.
inline void check_mpi(int code, const char* call) {
    if (code == MPI_SUCCESS)
        return;
    std::array<char, MPI_MAX_ERROR_STRING> text{};
    int length = 0;
    if (MPI_Error_string(code, text.data(), &length) != MPI_SUCCESS)
        length = 0;
    throw FarmError(std::string(call) + ": " +
                    std::string(text.data(), static_cast<std::size_t>(length)));
}

} // namespace culm::farm
