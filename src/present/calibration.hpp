// SPDX-License-Identifier: BSD-3-Clause
// The results of culm calibrate (docs/calibration-format.md).
#pragma once

#include "calibrate/calibration.hpp"
#include "calibrate/population.hpp"
#include "calibrate/study_calibration.hpp"
#include "diagnose/answers.hpp"
#include "present/provenance.hpp"

#include <optional>
#include <span>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

namespace culm::present {

/// A stem of calibration.json: its calibration or why there is none, and Y and β by the
/// regressions of a study.
struct CalibratedStem {
    std::string id;
    std::string folder;
    std::string law;     ///< of the bonds' damping
    std::string failure; ///< empty: it was calibrated
    std::optional<calibrate::Calibration> calibration;
    std::string study;         ///< its folder
    std::string study_failure; ///< why there is no result of the study
    std::optional<calibrate::StudyCalibration> by_study;
};
/// JSON as text, which travels between ranks.
[[nodiscard]] std::string stem_document(const CalibratedStem& stem);

/// Y, β and the verdict.
[[nodiscard]] std::string calibration_sentence(const calibrate::Calibration& calibration);
/// Mass, stiffness and frequency of the stem, which everybody can check.
[[nodiscard]] std::string stem_line_of(const calibrate::Calibration& calibration);

/// One stem as text; `law` is the name of its bonds' damping; `with_details`: with the uncertainty
/// budget, else with its largest shares.
[[nodiscard]] std::string calibration_text(const calibrate::Calibration& calibration,
                                           const std::string& law, bool with_details);

/// A table: every input with its standard uncertainty, its pull, and its contributions to the
/// uncertainties of Y, β and the effects' parameters; below it a sentence on the defaults used.
[[nodiscard]] std::string budget_text(const fit::UncertaintyBudget& budget,
                                      std::span<const fit::FittedParameter> parameters);

/// One sentence for each parameter: the causes of nine tenths of its variance; below it the
/// sentence on the defaults.
[[nodiscard]] std::string largest_shares_text(const fit::UncertaintyBudget& budget,
                                              std::span<const fit::FittedParameter> parameters);

/// Names the inputs whose default uncertainty applies; empty if there are none.
[[nodiscard]] std::string defaults_sentence(const fit::UncertaintyBudget& budget);

/// A table of stems: its head, and one line a stem.
[[nodiscard]] std::string calibration_table_head();
[[nodiscard]] std::string calibration_table_line(const calibrate::Calibration& calibration);

/// Y and β by a study's regressions.
[[nodiscard]] std::string study_calibration_text(const calibrate::StudyCalibration& found,
                                                 const std::string& study, const std::string& law);

[[nodiscard]] std::string population_text(const calibrate::Population& population);

/// calibration.json.
struct CalibrationDocument {
    std::string law;
    std::string effects;          ///< of --with
    std::optional<double> window; ///< s
    std::vector<diagnose::EffectAnswer> shared_effects;
    std::optional<calibrate::Population> population;
    std::vector<std::string> stems; ///< stem_document() of each
    std::vector<std::string> remarks;
    Provenance provenance;
};
[[nodiscard]] nlohmann::json calibration_json(const CalibrationDocument& document);
[[nodiscard]] nlohmann::json calibration_schema();

} // namespace culm::present
