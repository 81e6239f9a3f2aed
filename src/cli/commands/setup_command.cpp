// SPDX-License-Identifier: BSD-3-Clause
// culm setup VIDEO -o DIR: executes the Python program postprocess/setup.py.
#include "cli/command_line.hpp"
#include "cli/commands.hpp"
#include "cli/provenance.hpp"

#include <memory>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

namespace culm::cli {
namespace {

struct SetupArguments {
    std::string video;
    std::string output;
    bool is_text = false;
};

} // namespace

void add_setup_command(CLI::App& app) {
    CLI::App* command = app.add_subcommand(
        "setup", "Describe a video for culm track: in the browser, or with --text in the terminal");
    auto arguments = std::make_shared<SetupArguments>();
    add_option(*command, "video", arguments->video, "VIDEO",
               "Video file, Photron header (.cih, .cihx), folder of numbered pictures, or a "
               "pattern like frames/%05d.png")
        ->required();
    add_option(*command, "-o,--output", arguments->output, "DIR",
               "Folder for setup.html and video.toml; a link in it leads to the pictures")
        ->required();
    command->add_flag("--text", arguments->is_text,
                      "Ask in the terminal and write video.toml; no page");
    command->callback([arguments] {
        std::vector<std::string> words{"--culm-track=" + beside_own_program("culm-track").string(),
                                       "--program=" + version_text(),
                                       "--output=" + arguments->output};
        if (arguments->is_text)
            words.emplace_back("--text");
        words.insert(words.end(), {"--", arguments->video});
        run_python_program("setup.py", words, "culm setup needs Python 3");
    });
}

} // namespace culm::cli
