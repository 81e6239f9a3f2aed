// SPDX-License-Identifier: BSD-3-Clause
// Recordings and options that the tests of the diagnosis share.
#pragma once

#include "diagnose/diagnosis.hpp"
#include "measure/folder/measurement_folder.hpp"
#include "physics/effects/selection.hpp"

#include <filesystem>
#include <string>
#include <vector>

namespace culm::tests {

[[nodiscard]] inline std::vector<measure::Measurement> recording(const std::string& name) {
    const char* const folder = name == "T1-null" ? "measurements" : "hidden-effect";
    return {measure::read_measurement(std::filesystem::path(CULM_TEST_DATA_DIR) / folder / name)};
}

/// 20 spheres instead of 56: a third of the time, and the verdicts are the same (tests/regression).
[[nodiscard]] inline fit::FitOptions quick_fit() {
    fit::FitOptions options;
    options.chain.spheres = 20;
    return options;
}

[[nodiscard]] inline diagnose::DiagnosisOptions quick_diagnosis(const std::string& candidates) {
    diagnose::DiagnosisOptions options;
    options.candidate = quick_fit();
    options.candidates = physics::parse_effects(candidates, {});
    return options;
}

} // namespace culm::tests
