// SPDX-License-Identifier: BSD-3-Clause
// Every model that differs from the answer by one effect was fitted or is predicted to be clearly
// less likely.
#include "diagnose/search/search.hpp"
#include "diagnosis_records.hpp"
#include "fit/chain/stem_model.hpp"

#include <algorithm>
#include <cstddef>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace culm::tests {
namespace {

using Effects = std::vector<diagnose::ActingEffect>;

/// With one effect less, one more, or another one in its place.
std::vector<Effects> neighbours_of(const Effects& effects, const diagnose::Stems& stems) {
    std::vector<Effects> bases{effects};
    std::vector<Effects> neighbours;
    for (std::size_t k = 0; k < effects.size(); ++k) {
        bases.push_back(effects);
        bases.back().erase(bases.back().begin() + static_cast<std::ptrdiff_t>(k));
        neighbours.push_back(bases.back());
    }
    for (const Effects& base : bases)
        for (const physics::SelectedEffect& candidate : stems.options().candidates) {
            const Effects added{{candidate, {}, {0}, {}, false}};
            Effects larger = base;
            larger.push_back(added.front());
            if (larger.size() <= stems.options().most_effects &&
                !diagnose::contains_all(effects, added) && can_be_combined(larger, stems))
                neighbours.push_back(std::move(larger));
        }
    return neighbours;
}

class Neighbours : public ::testing::TestWithParam<std::string> {};

TEST_P(Neighbours, WereFittedOrAreClearlyLessLikely) {
    const std::vector<diagnose::Specimen> stem{{"one", {}, recording(GetParam())}};
    diagnose::DiagnosisOptions options;
    options.candidate = quick_fit();
    options.candidates = fit::in_library_order(fit::candidate_effects(stem.front().recordings));
    const diagnose::SearchResult found = diagnose::search_models(stem, options);
    const diagnose::Model& best = found.best_model();
    const double margin = options.policy.unvisited_margin * found.noise_ratio;
    std::size_t fitted = 0;
    std::size_t predicted = 0;
    for (const Effects& each : neighbours_of(best.effects, *found.stems)) {
        const diagnose::ModelKey key = diagnose::key_of(each);
        const auto has_key = [&](const auto& model) {
            return diagnose::key_of(model.effects) == key;
        };
        if (std::ranges::any_of(found.visited, has_key)) {
            ++fitted;
            continue;
        }
        const auto unvisited = std::ranges::find_if(found.unvisited, has_key);
        if (unvisited == found.unvisited.end()) {
            // No size of the allowed sign helps, or no run shows the effect.
            continue;
        }
        ++predicted;
        EXPECT_LE(unvisited->log_evidence, best.log_evidence - margin)
            << ::testing::PrintToString(key);
    }
    EXPECT_GE(fitted, best.effects.size() > 1 ? best.effects.size() : 1u);
    EXPECT_GE(predicted, options.candidates.size() / 2);
}

INSTANTIATE_TEST_SUITE_P(Recordings, Neighbours,
                         ::testing::Values("T2-quadratic_drag", "T3-clamp_compliance",
                                           "T7-quadratic_drag+clamp_compliance"),
                         [](const auto& given) { return given.param.substr(0, 2); });

} // namespace
} // namespace culm::tests
