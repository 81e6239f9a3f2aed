// SPDX-License-Identifier: BSD-3-Clause
// Scores on their way between ranks.
#include "diagnose/score_test.hpp"

#include <cmath>
#include <limits>

#include <nlohmann/json.hpp>

namespace culm::diagnose {
namespace {

/// Directions are only compared with each other.
constexpr double direction_unit = 1e-5;

} // namespace

std::string to_text(const EffectScore& score) {
    std::vector<int> direction;
    for (const double entry : score.direction)
        direction.push_back(static_cast<int>(std::lround(entry / direction_unit)));
    return nlohmann::json{score.effect,
                          score.failure,
                          score.gain,
                          score.added,
                          score.parameter,
                          score.unit,
                          std::isfinite(score.smallest_visible)
                              ? nlohmann::json(score.smallest_visible)
                              : nlohmann::json(nullptr),
                          score.is_beyond_bounds,
                          score.youngs_modulus_bias,
                          score.damping_bias,
                          direction,
                          score.null_gains}
        .dump();
}

EffectScore score_from_text(const std::string& text) {
    EffectScore score;
    if (text.empty()) {
        score.failure = "the rank that computed it was lost";
        return score;
    }
    const nlohmann::json told = nlohmann::json::parse(text);
    score.effect = told[0];
    score.failure = told[1];
    score.gain = told[2];
    score.added = told[3];
    score.parameter = told[4];
    score.unit = told[5];
    score.smallest_visible =
        told[6].is_null() ? std::numeric_limits<double>::infinity() : told[6].get<double>();
    score.is_beyond_bounds = told[7];
    score.youngs_modulus_bias = told[8];
    score.damping_bias = told[9];
    for (const auto& entry : told[10])
        score.direction.push_back(direction_unit * entry.get<int>());
    score.null_gains = told[11].get<std::vector<double>>();
    return score;
}

} // namespace culm::diagnose
