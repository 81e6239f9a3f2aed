// SPDX-License-Identifier: BSD-3-Clause
// An object that initialises and finalises MPI.
#pragma once

#include "farm/communicator.hpp"

namespace culm::farm {

/// Initialises MPI (one thread per rank communicates: MPI_THREAD_FUNNELED) and finalises it when it
/// goes out of scope. Works without mpirun, as a farm of one rank.
///
/// If it is destroyed by an exception while other ranks run, it calls MPI_Abort: they would wait
/// forever in their next collective call. Errors that all ranks find alike (bad input) should
/// therefore be caught inside the scope and lead to an ordinary return.
class Environment {
  public:
    /// Collective. Throws FarmError if MPI is already initialised or cannot be.
    Environment(int& argc, char**& argv);
    ~Environment();
    Environment(const Environment&) = delete;
    Environment& operator=(const Environment&) = delete;

    /// Duplicate of MPI_COMM_WORLD. Collective.
    [[nodiscard]] Communicator world() const { return Communicator::world(); }

    /// Whether this process was started by a parallel launcher (mpirun, srun with PMIx or PMI, …),
    /// judged by the environment variables that launchers set. Callable before MPI is initialised:
    /// a short command that runs alone need not initialise MPI.
    [[nodiscard]] static bool is_under_launcher();

    /// Number of processes that a launcher or a Slurm step started, by its environment variables; 1
    /// if there is none. If it exceeds the number of ranks, launcher and MPI do not fit.
    [[nodiscard]] static int started_processes();

  private:
    int exceptions_at_start_;
};

} // namespace culm::farm
