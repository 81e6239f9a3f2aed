// SPDX-License-Identifier: BSD-3-Clause
// What the commands that take recordings share: their options and results, and what fits of the
// chain will cost, said before they begin.
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

    [[nodiscard]] bool prints_text() const { return json != "-"; }
    /// Neither an estimate of the cost nor progress? `communicator` is null without a launcher.
    [[nodiscard]] bool is_silent(const farm::Communicator* communicator) const {
        return is_quiet || !prints_text() || !is_root(communicator);
    }
};

/// Measurements, --json, --output and --window; what each is for is the command's.
void add_recording_options(CLI::App& command, RecordingArguments& arguments, const char* paths,
                           const char* output, const char* window);
/// --law, --spheres and --quiet.
void add_chain_options(CLI::App& command, RecordingArguments& arguments);

[[nodiscard]] fit::ChainOptions chain_options(const RecordingArguments& arguments);

/// The options of the chain that differ from their defaults, each behind a space.
[[nodiscard]] std::string chain_words(const RecordingArguments& arguments);

/// Prints the remarks of the readers on standard error, and writes the document where --json says
/// and as `file` into the folder of --output, which is made.
void write_results(const RecordingArguments& arguments,
                   std::span<const measure::Measurement> recordings, const std::string& file,
                   const nlohmann::json& document);

// Each is a line for a person: how many fits, and the processor time that they take on the
// reference machine, from the least to the most that was measured for such recordings
// (docs/performance.md, "Fits"). Where Eq. 1 finds no vibration nothing is said of the time.

/// One model fitted to every recording.
[[nodiscard]] std::string cost_of_calibration(const std::vector<measure::Measurement>& recordings,
                                              const calibrate::CalibrationOptions& options,
                                              int ranks);

/// The published chain and growing models, each with two fits that leave readings out.
[[nodiscard]] std::string cost_of_ladder(const measure::Measurement& recording,
                                         const std::vector<fit::SelectedEffects>& models,
                                         const fit::FitOptions& options);

/// Every model fitted to every recording.
[[nodiscard]] std::string cost_of_table(const std::vector<measure::Measurement>& recordings,
                                        const std::vector<fit::SelectedEffects>& models,
                                        const fit::FitOptions& options, int ranks);

/// From recordings in which nothing is missing to those in which everything has to be tried.
[[nodiscard]] std::string cost_of_diagnosis(std::span<const measure::Measurement> recordings,
                                            const diagnose::DiagnosisOptions& options, int ranks);

} // namespace culm::cli
