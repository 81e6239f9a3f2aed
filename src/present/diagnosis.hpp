// SPDX-License-Identifier: BSD-3-Clause
// The results of culm diagnose (docs/diagnosis.md).
#pragma once

#include "core/describe.hpp"
#include "diagnose/diagnosis.hpp"
#include "measure/folder/measurement.hpp"
#include "present/provenance.hpp"

#include <span>
#include <string>
#include <vector>

namespace culm::present {

/// A diagnosis with its recordings, and how it was made.
struct DiagnosisReport {
    core::Viewed<diagnose::Diagnosis> found;
    std::span<const measure::Measurement> recordings;
    core::Viewed<diagnose::DiagnosisOptions> options;
    std::vector<std::string> folders{}; ///< (recordings)
    Provenance provenance{};

    /// The model whose residuals are nearest to noise.
    [[nodiscard]] const fit::Fit& best_fit() const { return found->final_fit; }
    /// Root mean square over the recordings, m.
    [[nodiscard]] double noise() const;
    /// The unit of the readings of all recordings.
    [[nodiscard]] measure::ReadingUnit unit() const;
    /// One sentence on an effect; empty if it is not a candidate.
    [[nodiscard]] std::string summary_of(const std::string& effect) const;
};

/// The verdict on one stem or several in one sentence.
[[nodiscard]] std::string diagnosis_headline(const diagnose::Diagnosis& found);
/// The explanations of a tie, and what is certain.
[[nodiscard]] std::vector<std::string> explanation_sentences(const diagnose::Diagnosis& found);
/// The effects of one explanation: "taper and clamp (clamp_compliance or clamp_friction)".
[[nodiscard]] std::string explanation_name(const diagnose::Diagnosis& found,
                                           const std::vector<diagnose::NamedFamily>& families);

/// "quadratic_drag"; of several stems "quadratic_drag of rig A", "taper of stems".
[[nodiscard]] std::vector<std::string>
effect_names(const std::vector<diagnose::OwnedEffect>& effects, bool is_one_stem = true);

/// diagnosis.json; of several stems laboratory_json().
[[nodiscard]] nlohmann::json diagnosis_json(const DiagnosisReport& report);
[[nodiscard]] nlohmann::json diagnosis_schema();

/// The verdict in sentences, the headline first.
[[nodiscard]] std::vector<std::string> diagnosis_sentences(const DiagnosisReport& report);

/// The verdict as text and the most informative experiment; without a named effect also the
/// detection limits. `with_details`: all tables. For several stems laboratory_text().
[[nodiscard]] std::string diagnosis_text(const DiagnosisReport& report, bool with_details);

} // namespace culm::present
