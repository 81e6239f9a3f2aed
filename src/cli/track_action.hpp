// SPDX-License-Identifier: BSD-3-Clause
// What culm track does once its command line is parsed.
#pragma once

#include "core/error.hpp"

#include <string>
#include <vector>

namespace culm::cli {

struct TrackArguments {
    std::vector<std::string> videos;
    std::string output;
    int threads = 0; ///< 0: all of the machine's, shared among the ranks
    bool with_video = false;
    bool is_quiet = false;
};

/// Tracks, writes and prints. There are two definitions: culm hands over to the program culm-track
/// beside it, which does the work. Only that one loads the video libraries: with their 180
/// dependencies they would multiply the time in which every other command, and every rank of a
/// study, starts.
[[nodiscard]] core::ExitCode run_track(const TrackArguments& arguments, int& argc, char**& argv);

} // namespace culm::cli
