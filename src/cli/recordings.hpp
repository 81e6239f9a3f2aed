// SPDX-License-Identifier: BSD-3-Clause
// Functions shared by the commands for recordings: their options and results.
#pragma once

#include "cli/command_line.hpp"
#include "diagnose/models/stems.hpp"
#include "measure/folder/measurement.hpp"

#include <optional>
#include <span>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

namespace CLI {
class App;
}

namespace culm::cli {

struct RecordingArguments {
    std::vector<std::string> paths;
    std::string json;   ///< file for all results; "-": standard output; empty: none
    std::string output; ///< folder; empty: none
    std::string law = "consistent";
    std::optional<int> spheres;
    std::optional<double> window_s;
    bool is_quiet = false;
    bool with_details = false; ///< of the commands that fit the chain

    [[nodiscard]] bool prints_text() const { return json != "-"; }
    /// No progress? `communicator` is null without a launcher.
    [[nodiscard]] bool is_silent(const farm::Communicator* communicator) const {
        return is_quiet || !prints_text() || !is_root(communicator);
    }
};

/// Adds measurements, --json, --output, --quiet and --window; their descriptions depend on the
/// command.
void add_recording_options(CLI::App& command, RecordingArguments& arguments, const char* paths,
                           const char* output, const char* window);
/// --law, --spheres and --details.
void add_chain_options(CLI::App& command, RecordingArguments& arguments);

[[nodiscard]] fit::ChainOptions chain_options(const RecordingArguments& arguments);

/// The options of the chain that differ from their defaults, each after a space.
[[nodiscard]] std::string chain_words(const RecordingArguments& arguments);
/// " --with EFFECT,...", if there are any, and chain_words().
[[nodiscard]] std::string model_words(const RecordingArguments& arguments,
                                      const std::vector<std::string>& effects);

/// "next: culm fit DIR" after an empty line; nothing with --quiet.
[[nodiscard]] std::string next_step(const RecordingArguments& arguments,
                                    const std::string& command);

/// Prints the readers' remarks on standard error. Writes the document to the file of --json, and as
/// `file` into the folder of --output, which is created.
void write_results(const RecordingArguments& arguments,
                   std::span<const measure::Measurement> recordings, const std::string& file,
                   const nlohmann::json& document);

} // namespace culm::cli
