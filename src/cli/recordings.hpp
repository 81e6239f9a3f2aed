// SPDX-License-Identifier: BSD-3-Clause
// Functions shared by the commands for recordings: their options and results, and the estimated
// cost of fits of the chain, printed before the fits begin.
#pragma once

#include "calibrate/calibration.hpp"
#include "cli/command_line.hpp"
#include "diagnose/diagnosis.hpp"
#include "measure/folder/measurement.hpp"

#include <optional>
#include <span>
#include <string>
#include <vector>

#include <CLI/App.hpp>
#include <nlohmann/json.hpp>

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
    /// Neither an estimate of the cost nor progress? `communicator` is null without a launcher.
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

/// "next: culm fit DIR" after an empty line; nothing with --quiet.
[[nodiscard]] std::string next_step(const RecordingArguments& arguments,
                                    const std::string& command);

/// Prints the readers' remarks on standard error. Writes the document to the file of --json, and as
/// `file` into the folder of --output, which is created.
void write_results(const RecordingArguments& arguments,
                   std::span<const measure::Measurement> recordings, const std::string& file,
                   const nlohmann::json& document);

// Each function returns a line for people: the number of fits, and the range of their processor
// time on the reference machine, as measured for such recordings (docs/performance.md, "Fits").
// Without a vibration according to Eq. 1 the time is omitted.

/// One model fitted to every recording.
[[nodiscard]] std::string cost_of_calibration(const std::vector<measure::Measurement>& recordings,
                                              const calibrate::CalibrationOptions& options,
                                              int ranks);

/// The published chain and growing models, each with two additional fits to a part of the readings.
[[nodiscard]] std::string cost_of_ladder(const measure::Measurement& recording,
                                         const std::vector<fit::SelectedEffects>& models,
                                         const fit::FitOptions& options);

/// Every model fitted to every recording.
[[nodiscard]] std::string cost_of_table(const std::vector<measure::Measurement>& recordings,
                                        const std::vector<fit::SelectedEffects>& models,
                                        const fit::FitOptions& options, int ranks);

/// The range extends from recordings without a missing effect to those that need a full search.
[[nodiscard]] std::string cost_of_diagnosis(std::span<const measure::Measurement> recordings,
                                            const diagnose::DiagnosisOptions& options, int ranks);

} // namespace culm::cli
