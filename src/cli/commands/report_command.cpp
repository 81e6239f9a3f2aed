// SPDX-License-Identifier: BSD-3-Clause
// culm report DIR -o report.html: executes the Python program postprocess/report.py.
#include "cli/command_line.hpp"
#include "cli/commands.hpp"
#include "cli/provenance.hpp"

#include <memory>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

namespace culm::cli {
namespace {

struct ReportArguments {
    std::string directory;
    std::string output;
    std::string d3_js;
};

} // namespace

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
