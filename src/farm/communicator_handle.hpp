// SPDX-License-Identifier: BSD-3-Clause
// The MPI object inside a Communicator; for the sources of this layer only.
#pragma once

#include <mpi.h>

namespace culm::farm {

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
