// SPDX-License-Identifier: BSD-3-Clause
#include "cli/own_program.hpp"
#include "cli/track_action.hpp"

#include <cerrno>
#include <cstring>
#include <filesystem>

#include <fmt/core.h>
#include <unistd.h>

namespace culm::cli {

core::ExitCode run_track(const TrackArguments&, int&, char**& argv) {
    const std::filesystem::path program = beside_own_program("culm-track");
    ::execv(program.c_str(), argv);
    throw core::StorageError(fmt::format("{}: cannot be run, though it belongs beside culm: {}",
                                         program.string(), std::strerror(errno)));
}

} // namespace culm::cli
