// SPDX-License-Identifier: BSD-3-Clause
// The results of culm compare: a ladder of models (docs/compare.md).
#pragma once

#include "core/describe.hpp"
#include "diagnose/ladder.hpp"
#include "present/provenance.hpp"

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace culm::present {

/// Index of the last model that improves on the one that it is compared with; 0: the baseline.
[[nodiscard]] std::size_t best_model(const diagnose::Ladder& ladder);

/// The uppermost model that could be fitted; null if none could.
[[nodiscard]] const diagnose::LadderModel* last_fitted(const diagnose::Ladder& ladder);

/// Does the published chain explain the measurement, and with which added effects does it?
[[nodiscard]] std::string comparison_headline(const diagnose::Ladder& ladder,
                                              const std::string& measurement);

/// One or two sentences: is the step to model `k` a gain, why, and how do Y and β change?
[[nodiscard]] std::vector<std::string> step_sentences(const diagnose::Ladder& ladder,
                                                      std::size_t k);

/// Up to three sentences: is the model adequate; where and when is the misfit largest; frequency
/// and damping against the amplitude, measured and modelled.
[[nodiscard]] std::vector<std::string> comparison_sentences(const diagnose::Comparison& comparison);

struct ComparisonOptions {
    std::string law;
    std::string with;
    std::string ladder;
    std::optional<double> window; ///< s
};

/// comparison.json: all models with their residuals and verdicts.
struct ComparisonDocument {
    core::Viewed<diagnose::Ladder> ladder;
    core::Viewed<measure::Measurement> measurement;
    std::string folder;
    ComparisonOptions options;
    Provenance provenance;
};
[[nodiscard]] nlohmann::json comparison_json(const ComparisonDocument& document);
[[nodiscard]] nlohmann::json comparison_schema();

/// The ladder, which steps are gains, and the parameters of the last model with three sentences on
/// it; `with_details`: the parameters of every model. `law` is that of the bonds' damping.
[[nodiscard]] std::string comparison_text(const diagnose::Ladder& ladder,
                                          const measure::Measurement& measurement,
                                          const std::string& law, bool with_details);

} // namespace culm::present
