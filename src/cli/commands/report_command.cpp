// SPDX-License-Identifier: BSD-3-Clause
// culm report DIR -o report.html: executes the Python program postprocess/report.py.
#include "cli/commands.hpp"
#include "cli/provenance.hpp"

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/core.h>
#include <unistd.h>

namespace culm::cli {
namespace {

struct ReportArguments {
    std::string directory;
    std::string output;
    std::string d3_js;
};

/// Path of the report program relative to this one, as installed or linked into a build tree.
/// Throws core::StorageError if it does not exist.
std::filesystem::path report_program() {
    std::filesystem::path program = beside_own_program("../share/culm/postprocess/report.py");
    if (!std::filesystem::exists(program))
        throw core::StorageError(
            fmt::format("{}: is not there; this program writes the report and belongs to culm's "
                        "installation",
                        program.string()));
    return program;
}

/// Replaces this process; returns only by throwing.
[[noreturn]] void hand_over(const ReportArguments& arguments) {
    const char* named = std::getenv("CULM_PYTHON");
    std::vector<std::string> words = {named != nullptr && *named != '\0' ? named : "python3", "-B",
                                      report_program().string()};
    if (!arguments.output.empty())
        words.push_back("--output=" + arguments.output);
    if (!arguments.d3_js.empty())
        words.push_back("--d3-js=" + arguments.d3_js);
    words.insert(words.end(), {"--", arguments.directory});
    std::vector<char*> argv;
    argv.reserve(words.size() + 1);
    for (std::string& word : words)
        argv.push_back(word.data());
    argv.push_back(nullptr);
    std::fflush(nullptr);
    ::execvp(argv.front(), argv.data());
    throw core::StorageError(fmt::format(
        "{}: cannot be run: {}; a report needs Python 3 with h5py and numpy "
        "(jobs/install-packages.sh figures report; the variable CULM_PYTHON names another Python)",
        words.front(), std::strerror(errno)));
}

} // namespace

void add_report_command(CLI::App& app) {
    CLI::App* command = app.add_subcommand(
        "report", "Write the results of a folder as one page with figures (docs/report.md)");
    auto arguments = std::make_shared<ReportArguments>();
    command
        ->add_option("directory", arguments->directory,
                     "Folder that culm run, track, fit, calibrate, compare or diagnose wrote with "
                     "-o, or a folder of such folders")
        ->required()
        ->type_name("DIR");
    command
        ->add_option("-o,--output", arguments->output,
                     "The page to write (default: DIR/report.html)")
        ->type_name("FILE");
    command
        ->add_option("--d3-js", arguments->d3_js,
                     "The drawing library D3 (version 3), if it is not found automatically")
        ->type_name("FILE");
    command->callback([arguments] { hand_over(*arguments); });
}

} // namespace culm::cli
