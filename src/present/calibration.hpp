// SPDX-License-Identifier: BSD-3-Clause
// The results of culm calibrate (docs/calibration-format.md).
#pragma once

#include "calibrate/calibration.hpp"
#include "present/text_style.hpp"

#include <cstddef>
#include <optional>
#include <span>
#include <string>

#include <nlohmann/json_fwd.hpp>

namespace culm::present {

/// One stem that was calibrated; `law` is the name of its bonds' damping.
[[nodiscard]] nlohmann::json calibration_json(const calibrate::Calibration& calibration,
                                              const std::string& law);
/// The same as text; `with_details`: with the uncertainty budget, else with its largest shares.
[[nodiscard]] std::string calibration_text(const calibrate::Calibration& calibration,
                                           const std::string& law, bool with_details,
                                           const TextStyle& style);

/// A table: every input with its standard uncertainty, its pull, and its contributions to the
/// uncertainties of Y, β and the effects' parameters; below it a sentence on the defaults used.
[[nodiscard]] std::string budget_text(const fit::UncertaintyBudget& budget,
                                      std::span<const fit::FittedParameter> parameters);

/// One sentence for each parameter: the causes of nine tenths of its variance; below it the
/// sentence on the defaults.
[[nodiscard]] std::string largest_shares_text(const fit::UncertaintyBudget& budget,
                                              std::span<const fit::FittedParameter> parameters);

/// {"inputs": [{"name", "unit", "value", "standard_uncertainty", "default", "pull",
/// "uncertainty_with_readings", "sensitivities", "shares"}], "readings": {"standard_uncertainties",
/// "shares"}, "combined", "sentences"}; maps are by parameter_key().
[[nodiscard]] nlohmann::json budget_json(const fit::UncertaintyBudget& budget,
                                         std::span<const fit::FittedParameter> parameters);

/// A table of stems: its head, and one line a stem. `is_checked`: with the errors of the check.
[[nodiscard]] std::string calibration_table_head(bool is_checked);
[[nodiscard]] std::string calibration_table_line(const calibrate::Calibration& calibration,
                                                 bool is_checked, const TextStyle& style);

/// Y and β by a study's regressions: the member "via" of a stem.
[[nodiscard]] nlohmann::json study_calibration_json(const calibrate::StudyCalibration& found,
                                                    const std::string& study);
[[nodiscard]] std::string study_calibration_text(const calibrate::StudyCalibration& found,
                                                 const std::string& study, const std::string& law,
                                                 const TextStyle& style);

/// A stem's contribution to the population, which is sent between ranks.
struct StemNumbers {
    double bond_youngs_modulus = 0.0; ///< Pa
    double bond_damping = 0.0;
    double decay_per_cycle = 0.0;
    double frequency = 0.0; ///< Hz
    bool is_adequate = false;
};

template <class Wire>
void fields(Wire& wire, StemNumbers& stem) {
    wire(stem.bond_youngs_modulus, stem.bond_damping, stem.decay_per_cycle, stem.frequency,
         stem.is_adequate);
}

[[nodiscard]] StemNumbers numbers_of(const calibrate::Calibration& calibration);

/// The population of two or more calibrated stems.
struct Population {
    std::size_t stems = 0; ///< calibrated
    std::size_t failed = 0;
    std::size_t inadequate = 0;
    calibrate::CentralRange bond_youngs_modulus; ///< Pa
    calibrate::CentralRange bond_damping;
    calibrate::CentralRange decay_per_cycle;
    calibrate::CentralRange frequency; ///< Hz
};

/// Returns nothing for fewer than two calibrated stems.
[[nodiscard]] std::optional<Population> population_of(std::span<const StemNumbers> calibrated,
                                                      std::size_t failed);
[[nodiscard]] nlohmann::json population_json(const Population& population);
[[nodiscard]] std::string population_text(const Population& population);

} // namespace culm::present
