// SPDX-License-Identifier: BSD-3-Clause
// MPI's return codes as exceptions, and its communicator as an object; for the sources of this
// layer only.
#pragma once

#include "farm/batch.hpp"

#include <array>
#include <cstddef>
#include <limits>
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

/// MPI counts bytes in an int. Throws FarmError if a message has more.
inline int message_length(std::size_t size) {
    if (size > static_cast<std::size_t>(std::numeric_limits<int>::max()))
        throw FarmError("a message of " + std::to_string(size) + " bytes is too long for MPI");
    return static_cast<int>(size);
}

/// Owns a duplicate of `parent`, with errors returned instead of fatal.
struct CommunicatorHandle {
    explicit CommunicatorHandle(MPI_Comm parent);
    ~CommunicatorHandle();
    CommunicatorHandle(const CommunicatorHandle&) = delete;
    CommunicatorHandle& operator=(const CommunicatorHandle&) = delete;

    MPI_Comm mpi = MPI_COMM_NULL;
    int rank = 0;
    int size = 1;
};

} // namespace culm::farm
