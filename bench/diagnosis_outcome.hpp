// SPDX-License-Identifier: BSD-3-Clause
// What the diagnosis says of one recording: the only place where the benchmark meets it.
#pragma once

#include "diagnose/diagnosis.hpp"
#include "measure/folder/measurement.hpp"

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace culm::bench {

struct FoundParameter {
    std::string name; ///< "effect.parameter"
    double value = 0.0;
    double standard_error = 0.0;
};

struct FoundFamily {
    std::string family;
    std::vector<std::string> members;
};

struct Outcome {
    std::string verdict;               ///< "adequate", "effect", "tie", "unknown"; "failed"
    std::string reason;                ///< one sentence
    std::vector<std::string> effects;  ///< of the answer
    std::vector<FoundFamily> families; ///< that are certain
    std::vector<std::vector<std::string>> ties; ///< an effect of the answer, then its rivals
    std::vector<FoundParameter> parameters;     ///< of the best model that was reached
    double baseline_misfit = 0.0;               ///< rmse over noise
    double final_misfit = 0.0;
    int runs = 0;         ///< of the chain with all its derivatives
    double seconds = 0.0; ///< of processor time
};

/// Diagnoses the recording on this process alone. Never throws but run::Abandoned: what could not
/// be diagnosed has the verdict "failed".
[[nodiscard]] Outcome diagnosed(const measure::Measurement& measurement,
                                const diagnose::DiagnosisOptions& options);

/// Each effect of the answer with the other explanations that hold 95 % with it.
[[nodiscard]] std::vector<std::vector<std::string>> ties_of(const diagnose::Diagnosis& found);

/// A diagnosis that did not end, and why.
[[nodiscard]] Outcome no_answer(const std::string& reason, double cpu_s);

void to_json(nlohmann::json& json, const Outcome& outcome);
void from_json(const nlohmann::json& json, Outcome& outcome);

} // namespace culm::bench
