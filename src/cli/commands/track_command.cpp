// SPDX-License-Identifier: BSD-3-Clause
// culm track VIDEO.toml... -o DIR
#include "cli/options.hpp"

namespace culm::cli {

void add_track_command(CLI::App& app, core::ExitCode& exit_code, int& argc, char**& argv) {
    CLI::App* command = app.add_subcommand(
        "track", "Measure a stem's deflections in a high-speed video (docs/tracking.md)");
    auto arguments = std::make_shared<TrackArguments>();
    add_option(*command, "videos", arguments->videos, "VIDEO.toml",
               "Descriptions of recordings; several are shared among the ranks of mpirun")
        ->required();
    add_option(*command, "-o,--output", arguments->output, "DIR",
               "Folder for stem.toml, deflection.csv, track.json and contact_sheet.png; of "
               "several videos each gets a folder in it, named by its stem's id")
        ->required();
    add_option(*command, "--threads", arguments->threads, "N",
               "Threads that share the frames of one video (default: all cores)")
        ->check(CLI::Range(1, 1024));
    command->add_flag("-q,--quiet", arguments->is_quiet, "No progress");
    command->callback(
        [arguments, &exit_code, &argc, &argv] { exit_code = run_track(*arguments, argc, argv); });
}

} // namespace culm::cli
