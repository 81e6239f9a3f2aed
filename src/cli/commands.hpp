// SPDX-License-Identifier: BSD-3-Clause
// The commands of culm; one source file each, except those that execute a Python program.
#pragma once

#include "core/error.hpp"

#include <string>
#include <vector>

#include <CLI/App.hpp>

namespace culm::cli {

/// The result of a command for main().
struct CommandResult {
    core::ExitCode exit_code = core::ExitCode::Done;
};

/// Each function adds its command to `app`. The command runs when it is parsed and stores its exit
/// code in `result`, which must outlive the parsing. `argc` and `argv` are main's, for MPI.
void add_run_command(CLI::App& app, CommandResult& result, int& argc, char**& argv);
void add_reduce_command(CLI::App& app, CommandResult& result);
void add_archive_command(CLI::App& app, CommandResult& result);
void add_jobs_command(CLI::App& app);
void add_simulate_command(CLI::App& app, CommandResult& result);
void add_import_command(CLI::App& app, CommandResult& result);
void add_fit_command(CLI::App& app, CommandResult& result);
void add_setup_command(CLI::App& app);
void add_track_command(CLI::App& app, CommandResult& result, int& argc, char**& argv);
void add_calibrate_command(CLI::App& app, CommandResult& result, int& argc, char**& argv);
void add_compare_command(CLI::App& app, CommandResult& result, int& argc, char**& argv);
void add_diagnose_command(CLI::App& app, CommandResult& result, int& argc, char**& argv);
void add_export_command(CLI::App& app);
void add_effects_command(CLI::App& app);
void add_keys_command(CLI::App& app);
void add_report_command(CLI::App& app);

struct TrackArguments {
    std::vector<std::string> videos;
    std::string output;
    int threads = 0; ///< 0: all of the machine's, shared among the ranks
    bool with_video = false;
    bool is_quiet = false;
};

/// Tracks, writes and prints. There are two definitions: in culm (main.cpp) the function executes
/// the program culm-track of the same folder, in which it does the work (track_main.cpp). Only
/// culm-track loads the video libraries: their 180 dependencies would multiply the time in which
/// every other command, and every rank of a study, starts.
[[nodiscard]] core::ExitCode run_track(const TrackArguments& arguments, int& argc, char**& argv);

} // namespace culm::cli
