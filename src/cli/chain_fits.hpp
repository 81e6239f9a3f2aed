// SPDX-License-Identifier: BSD-3-Clause
// What calibrate, compare and diagnose share: options of the chain that they fit to recordings, and
// what the fits will cost, said before they begin.
#pragma once

#include "calibrate/calibration.hpp"
#include "diagnose/diagnosis.hpp"
#include "measure/folder/measurement.hpp"

#include <optional>
#include <span>
#include <string>
#include <vector>

#include <CLI/App.hpp>

namespace culm::cli {

struct ChainArguments {
    std::string law = "consistent";
    std::optional<int> spheres;
    std::optional<double> window_s;
};

/// --law, --spheres and --window; `window_use` says what only the first seconds are for.
void add_chain_options(CLI::App& command, ChainArguments& arguments, const char* window_use);

[[nodiscard]] fit::ChainOptions chain_options(const ChainArguments& arguments);

/// The options that differ from their defaults, each behind a space.
[[nodiscard]] std::string chain_words(const ChainArguments& arguments);

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
