// SPDX-License-Identifier: BSD-3-Clause
// The commands that execute a Python program of postprocess/: culm setup VIDEO -o DIR (setup.py),
// culm import MAPPING.toml|RECORDING -o DIR (import_recording.py), culm report DIR (report.py).
#include "cli/options.hpp"
#include "cli/provenance.hpp"
#include "core/error.hpp"
#include "measure/folder/measurement_files.hpp"

#include <string>
#include <vector>

namespace culm::cli {
namespace {

struct ProgramArguments {
    std::string input; ///< video, mapping or folder
    std::string output;
    std::string recording;
    std::string d3_js;
    bool is_text = false;
};

/// Mistakes in a mapping's tables on the stem, which are those of stem.toml. The other tables are
/// read by the Python program.
std::string stem_faults(const std::string& mapping) {
    core::TomlDocument document(mapping);
    for (const char* name : {"source", "time", "motion", "clamp", "height"})
        document.root().leave(name);
    measure::Measurement measurement;
    measure::read_stem_tables(document.root(), measurement);
    try {
        document.finish();
    } catch (const core::InputError& error) {
        return error.what();
    }
    return {};
}

void import_measurement(const ProgramArguments& arguments) {
    std::vector<std::string> words{"--output=" + arguments.output,
                                   "--culm-track=" + beside_own_program("culm-track").string()};
    if (!arguments.recording.empty())
        words.push_back("--recording=" + arguments.recording);
    if (arguments.input.ends_with(".toml"))
        words.push_back("--stem-faults=" + stem_faults(arguments.input));
    words.insert(words.end(), {"--", arguments.input});
    run_python_program("import_recording.py", words,
                       "an import needs Python 3 with numpy, pandas, scipy and h5py "
                       "(jobs/install-packages.sh figures)");
}

} // namespace

void add_import_command(CLI::App& app) {
    CLI::App* command = app.add_subcommand(
        "import", "Make a measurement folder from a recording of another program");
    auto arguments = std::make_shared<ProgramArguments>();
    add_option(*command, "mapping", arguments->input, "MAPPING.toml",
               "What the recording's columns or markers are (docs/measurements.md); of a "
               "recording itself (.csv, .lvm, .trk, .mat, ...) a mapping is proposed")
        ->required();
    add_option(*command, "--recording", arguments->recording, "FILE",
               "The recording, instead of the one that the mapping names");
    add_option(*command, "-o,--output", arguments->output, "DIR", "Measurement folder to write")
        ->required();
    command->callback([arguments] { import_measurement(*arguments); });
}

void add_setup_command(CLI::App& app) {
    CLI::App* command = app.add_subcommand(
        "setup", "Describe a video for culm track: in the browser, or with --text in the terminal");
    auto arguments = std::make_shared<ProgramArguments>();
    add_option(*command, "video", arguments->input, "VIDEO",
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
        words.insert(words.end(), {"--", arguments->input});
        run_python_program("setup.py", words, "culm setup needs Python 3");
    });
}

void add_report_command(CLI::App& app) {
    CLI::App* command = app.add_subcommand(
        "report", "Write the results of a folder as one page with figures (docs/report.md)");
    auto arguments = std::make_shared<ProgramArguments>();
    add_option(*command, "directory", arguments->input, "DIR",
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
        words.insert(words.end(), {"--", arguments->input});
        run_python_program("report.py", words,
                           "a report needs Python 3 with h5py and numpy (jobs/install-packages.sh "
                           "figures report)");
    });
}

} // namespace culm::cli
