// SPDX-License-Identifier: BSD-3-Clause
#include "farm/environment.hpp"

#include "farm/mpi_calls.hpp"

#include <cstdlib>
#include <string_view>

#ifdef __SANITIZE_ADDRESS__
#include <sanitizer/lsan_interface.h>

/// PMIx, which connects a rank with its launcher, leaks a few bytes in its own thread.
// NOLINTNEXTLINE(bugprone-reserved-identifier): LeakSanitizer asks for this function by its name
extern "C" const char* __lsan_default_suppressions() {
    return "leak:libpmix";
}
// NOLINTNEXTLINE(bugprone-reserved-identifier): likewise
extern "C" const char* __lsan_default_options() {
    return "print_suppressions=0";
}
#endif

namespace culm::farm {

namespace {

/// Allocations of MPI_Init, much of which Open MPI never frees, do not count as leaks of culm.
int initialise_mpi(int& argc, char**& argv) {
#ifdef __SANITIZE_ADDRESS__
    const __lsan::ScopedDisabler not_ours;
#endif
    int provided = MPI_THREAD_SINGLE;
    check_mpi(MPI_Init_thread(&argc, &argv, MPI_THREAD_FUNNELED, &provided), "MPI_Init_thread");
    return provided;
}

} // namespace

Environment::Environment(int& argc, char**& argv)
    : exceptions_at_start_(std::uncaught_exceptions()) {
    int is_initialized = 0;
    check_mpi(MPI_Initialized(&is_initialized), "MPI_Initialized");
    if (is_initialized != 0)
        throw FarmError("MPI is already initialised: there can be only one Environment");
    if (initialise_mpi(argc, argv) < MPI_THREAD_FUNNELED) {
        MPI_Finalize();
        throw FarmError("this MPI library does not allow threads other than the communicating one");
    }
}

Environment::~Environment() {
    // MPI_Finalize is collective. A rank that leaves by an exception would wait there for ranks
    // that wait for its messages, so it ends all ranks.
    int size = 1;
    MPI_Comm_size(MPI_COMM_WORLD, &size);
    if (size > 1 && std::uncaught_exceptions() > exceptions_at_start_) {
        MPI_Abort(MPI_COMM_WORLD, EXIT_FAILURE);
        std::abort(); // MPI_Abort does not return, but the standard does not promise it
    }
#ifdef __SANITIZE_ADDRESS__
    // Reports leaks of culm and ends the process if there are any, before MPI_Finalize unloads Open
    // MPI's plugins: memory that they keep until the end of the process looks like leaks
    // afterwards.
    __lsan_do_leak_check();
#endif
    MPI_Finalize();
}

bool Environment::is_under_launcher() {
    // Open MPI's mpirun; PMIx (srun --mpi=pmix, prun); PMI (MPICH, Intel MPI, srun --mpi=pmi2).
    for (const char* name : {"OMPI_COMM_WORLD_SIZE", "PMIX_RANK", "PMI_RANK", "PMI_FD"})
        if (std::getenv(name) != nullptr)
            return true;
    return false;
}

int Environment::started_processes() {
    // A batch script outside of a step has SLURM_NTASKS too, but is one process.
    const bool is_step = std::getenv("SLURM_STEP_ID") != nullptr;
    for (const char* name :
         {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "SLURM_STEP_NUM_TASKS", "SLURM_NTASKS"})
        if (const char* value = std::getenv(name);
            value != nullptr && (is_step || std::string_view(name).substr(0, 5) != "SLURM"))
            if (const int count = std::atoi(value); count > 0)
                return count;
    return 1;
}

} // namespace culm::farm
