// SPDX-License-Identifier: BSD-3-Clause
// culm setup VIDEO -o DIR
#include "cli/commands.hpp"

#include <memory>

#include <CLI/CLI.hpp>

namespace culm::cli {

void add_setup_command(CLI::App& app, CommandResult& result, char**& argv) {
    CLI::App* command = app.add_subcommand(
        "setup", "Describe a video for culm track: in the browser, or with --text in the terminal");
    auto arguments = std::make_shared<SetupArguments>();
    command
        ->add_option("video", arguments->video,
                     "Video file, Photron header (.cih, .cihx), folder of numbered pictures, or a "
                     "pattern like frames/%05d.png")
        ->required()
        ->type_name("VIDEO");
    command
        ->add_option("-o,--output", arguments->output,
                     "Folder for setup.html and video.toml; a link in it leads to the pictures")
        ->required()
        ->type_name("DIR");
    command->add_flag("--text", arguments->is_text,
                      "Ask in the terminal and write video.toml; no page");
    command->callback(
        [arguments, &result, &argv] { result.exit_code = run_setup(*arguments, argv); });
}

} // namespace culm::cli
