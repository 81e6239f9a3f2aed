// SPDX-License-Identifier: BSD-3-Clause
// culm import MAPPING.toml|RECORDING -o DIR: executes postprocess/import_recording.py.
#include "cli/options.hpp"
#include "cli/provenance.hpp"
#include "core/error.hpp"
#include "measure/folder/measurement_files.hpp"

#include <string>
#include <vector>

namespace culm::cli {
namespace {

struct ImportArguments {
    std::string mapping;
    std::string recording;
    std::string output;
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

void import_measurement(const ImportArguments& arguments) {
    std::vector<std::string> words{"--output=" + arguments.output,
                                   "--culm-track=" + beside_own_program("culm-track").string()};
    if (!arguments.recording.empty())
        words.push_back("--recording=" + arguments.recording);
    if (arguments.mapping.ends_with(".toml"))
        words.push_back("--stem-faults=" + stem_faults(arguments.mapping));
    words.insert(words.end(), {"--", arguments.mapping});
    run_python_program("import_recording.py", words,
                       "an import needs Python 3 with numpy, pandas, scipy and h5py "
                       "(jobs/install-packages.sh figures)");
}

} // namespace

void add_import_command(CLI::App& app) {
    CLI::App* command = app.add_subcommand(
        "import", "Make a measurement folder from a recording of another program");
    auto arguments = std::make_shared<ImportArguments>();
    add_option(*command, "mapping", arguments->mapping, "MAPPING.toml",
               "What the recording's columns or markers are (docs/measurements.md); of a "
               "recording itself (.csv, .lvm, .trk, .mat, ...) a mapping is proposed")
        ->required();
    add_option(*command, "--recording", arguments->recording, "FILE",
               "The recording, instead of the one that the mapping names");
    add_option(*command, "-o,--output", arguments->output, "DIR", "Measurement folder to write")
        ->required();
    command->callback([arguments] { import_measurement(*arguments); });
}

} // namespace culm::cli
