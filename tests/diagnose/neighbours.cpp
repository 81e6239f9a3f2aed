// SPDX-License-Identifier: BSD-3-Clause
// Every model that differs from the answer by one effect was fitted or is predicted to be clearly
// less likely.
#include "diagnose/model_search.hpp"
#include "diagnosis_records.hpp"
#include "fit/chain/stem_model.hpp"

#include <algorithm>
#include <cstddef>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace culm::tests {
namespace {

/// With one effect less, one more, or another one in its place.
std::vector<fit::SelectedEffects> neighbours_of(const fit::SelectedEffects& effects,
                                                const diagnose::DiagnosisOptions& options) {
    std::vector<fit::SelectedEffects> bases{effects};
    std::vector<fit::SelectedEffects> neighbours;
    for (std::size_t k = 0; k < effects.size(); ++k) {
        bases.push_back(effects);
        bases.back().erase(bases.back().begin() + static_cast<std::ptrdiff_t>(k));
        neighbours.push_back(bases.back());
    }
    for (const fit::SelectedEffects& base : bases)
        for (const physics::SelectedEffect& candidate : options.candidates) {
            fit::SelectedEffects larger = base;
            larger.push_back(candidate);
            if (larger.size() <= options.most_effects && !fit::contains(effects, candidate) &&
                diagnose::can_be_combined(larger))
                neighbours.push_back(std::move(larger));
        }
    return neighbours;
}

class Neighbours : public ::testing::TestWithParam<std::string> {};

TEST_P(Neighbours, WereFittedOrAreClearlyLessLikely) {
    const std::vector<measure::Measurement> recordings = recording(GetParam());
    diagnose::DiagnosisOptions options;
    options.candidate = quick_fit();
    options.candidates = fit::in_library_order(fit::candidate_effects(recordings));
    const diagnose::SearchResult found = diagnose::search_models(recordings, options);
    const diagnose::VisitedModel& best = found.visited[found.best];
    const double margin = options.policy.unvisited_margin * found.noise.mean_known();
    std::size_t fitted = 0;
    std::size_t predicted = 0;
    for (const fit::SelectedEffects& each : neighbours_of(best.fit.effects, options)) {
        const diagnose::ModelKey key = diagnose::key_of(each);
        const auto has_key = [&](const auto& effects) { return diagnose::key_of(effects) == key; };
        if (std::ranges::any_of(found.visited,
                                [&](const auto& model) { return has_key(model.fit.effects); })) {
            ++fitted;
            continue;
        }
        const auto unvisited = std::ranges::find_if(
            found.unvisited, [&](const auto& model) { return has_key(model.effects); });
        if (unvisited == found.unvisited.end()) {
            // No size of the allowed sign helps, or no run shows the effect.
            continue;
        }
        ++predicted;
        EXPECT_LE(unvisited->log_evidence, best.log_evidence - margin)
            << ::testing::PrintToString(key);
    }
    EXPECT_GE(fitted, best.fit.effects.size() > 1 ? best.fit.effects.size() : 1u);
    EXPECT_GE(predicted, options.candidates.size() / 2);
}

INSTANTIATE_TEST_SUITE_P(Recordings, Neighbours,
                         ::testing::Values("T2-quadratic_drag", "T3-clamp_compliance",
                                           "T7-quadratic_drag+clamp_compliance"),
                         [](const auto& given) { return given.param.substr(0, 2); });

} // namespace
} // namespace culm::tests
