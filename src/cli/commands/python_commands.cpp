// SPDX-License-Identifier: BSD-3-Clause
// The commands that execute a Python program: culm setup VIDEO -o DIR (postprocess/setup.py) and
// culm report DIR -o report.html (postprocess/report.py).
#include "cli/options.hpp"
#include "cli/provenance.hpp"

#include <string>
#include <vector>

namespace culm::cli {
namespace {

struct SetupArguments {
    std::string video;
    std::string output;
    bool is_text = false;
};

struct ReportArguments {
    std::string directory;
    std::string output;
    std::string d3_js;
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

void add_report_command(CLI::App& app) {
    CLI::App* command = app.add_subcommand(
        "report", "Write the results of a folder as one page with figures (docs/report.md)");
    auto arguments = std::make_shared<ReportArguments>();
    add_option(*command, "directory", arguments->directory, "DIR",
               "Folder that culm run, track, fit, calibrate, compare or diagnose wrote with "
               "-o, or a folder of such folders")
        ->required();
    add_option(*command, "-o,--output", arguments->output, "FILE",
               "The page to write (default: DIR/report.html)");
    add_option(*command, "--d3-js", arguments->d3_js, "FILE",
               "The drawing library D3 (version 3), if it is not found automatically");
    command->callback([arguments] {
        std::vector<std::string> words;
        if (!arguments->output.empty())
            words.push_back("--output=" + arguments->output);
        if (!arguments->d3_js.empty())
            words.push_back("--d3-js=" + arguments->d3_js);
        words.insert(words.end(), {"--", arguments->directory});
        run_python_program("report.py", words,
                           "a report needs Python 3 with h5py and numpy (jobs/install-packages.sh "
                           "figures report)");
    });
}

} // namespace culm::cli
