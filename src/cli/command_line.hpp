// SPDX-License-Identifier: BSD-3-Clause
// Common functions of the commands of culm: messages, the suggested next command, and execution in
// one process or on the ranks of a launcher.
#pragma once

#include "core/error.hpp"
#include "farm/communicator.hpp"

#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace culm::cli {

/// "culm: reason" on standard error.
void print_error(std::string_view reason);

/// "culm: note: text" and "culm: warning: text" on standard error.
void print_note(std::string_view text);
void print_warning(std::string_view text);

/// Warns if a launcher started more processes than take part: each does the whole work.
void warn_of_copies(int ranks);

/// The words quoted for a shell, each after a space.
[[nodiscard]] std::string as_words(const std::vector<std::string>& words);

/// "next: culm fit DIR" after an empty line.
[[nodiscard]] std::string next_step(const std::string& command);

/// Calls `action`; prints an InputError or StorageError that it throws if `prints`, and returns the
/// exit code of bad input then.
[[nodiscard]] core::ExitCode with_refusals(bool prints,
                                           const std::function<core::ExitCode()>& action);

/// Calls `action` with the ranks of the launcher, or with null if no launcher started this process.
/// Under a launcher every rank meets the same InputError or StorageError, and rank 0 prints it.
[[nodiscard]] core::ExitCode
alone_or_under_launcher(int& argc, char**& argv,
                        const std::function<core::ExitCode(const farm::Communicator*)>& action);

/// Does this process print? `communicator` is null without a launcher.
[[nodiscard]] inline bool is_root(const farm::Communicator* communicator) {
    return communicator == nullptr || communicator->rank() == 0;
}
[[nodiscard]] inline int rank_count(const farm::Communicator* communicator) {
    return communicator == nullptr ? 1 : communicator->size();
}

struct TrackArguments {
    std::vector<std::string> videos;
    std::string output;
    int threads = 0; ///< 0: all of the machine's, shared among the ranks
    bool is_quiet = false;
};

/// Tracks, writes and prints. There are two definitions: in culm (main.cpp) the function executes
/// the program culm-track of the same folder, in which it does the work (track_main.cpp). Only
/// culm-track loads the video libraries: their 180 dependencies would multiply the time in which
/// every other command, and every rank of a study, starts.
[[nodiscard]] core::ExitCode run_track(const TrackArguments& arguments, int& argc, char**& argv);

} // namespace culm::cli
