// SPDX-License-Identifier: BSD-3-Clause
// Which models explain recordings: log evidence is predicted for all sets of effects and computed
// for the few that matter.
#pragma once

#include "core/item_map.hpp"
#include "diagnose/evidence/effect_columns.hpp"
#include "diagnose/evidence/log_evidence.hpp"
#include "diagnose/planned_model.hpp"
#include "diagnose/policy.hpp"
#include "fit/fit_model.hpp"

#include <functional>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace culm::diagnose {

struct DiagnosisOptions {
    fit::FitOptions candidate;
    fit::SelectedEffects known;      ///< that certainly act; part of every model
    fit::SelectedEffects candidates; ///< in the library's order
    std::size_t most_effects = 3;
    core::ItemMap map;
    std::function<void(const std::string&)> progress; ///< receives the next step; may be empty
    Policy policy;

    void report(const std::string& next) const {
        if (progress)
            progress(next);
    }
};

/// A model that was fitted.
struct VisitedModel : FittedModel {
    double log_evidence = -std::numeric_limits<double>::infinity();

    /// −infinity stays if it was not fitted, or not with all its effects.
    void judge(const NoiseScale& noise);
};

/// A model whose log evidence was only predicted.
struct UnvisitedModel {
    fit::SelectedEffects effects;
    double log_evidence = 0.0;
    std::size_t base = 0;           ///< the visited model about which it was predicted
    std::vector<std::string> added; ///< effects that it adds to that
    std::vector<double> falls;      ///< (added) of χ² by each of them alone
};

struct SearchResult {
    fit::BaselineFit chain;                ///< the published chain
    std::vector<VisitedModel> visited;     ///< the published chain (with what is known) first
    std::vector<UnvisitedModel> unvisited; ///< the largest log evidence first
    std::size_t best = 0;                  ///< of the visited models
    NoiseScale noise;                      ///< about the best model
    fit::Fit best_fit;                     ///< with residuals and derivatives
    std::vector<CandidateView> views;      ///< candidates about the best model
    int batches = 0;                       ///< of lanes that were run for the fits of models
    bool is_complete = true;               ///< false: it ended at the largest number of models
};

/// The published chain with the effects that are known to act, fitted about the baseline. Throws
/// core::NumericalError if it cannot be fitted.
[[nodiscard]] fit::Fit first_model(const fit::BaselineFit& baseline,
                                   const DiagnosisOptions& options);

/// The likeliest model with one of the effects of this one, if it has several.
[[nodiscard]] std::optional<std::size_t>
likeliest_part(const SearchResult& search, std::size_t model, const DiagnosisOptions& options);

/// Calls visit(set) for the sets of at most `room` of the numbers 0 … count − 1, in the order of
/// their names in a dictionary; false: no set that begins with this one is visited.
template <class Visit>
void for_each_set(std::size_t count, std::size_t room, const Visit& visit,
                  std::vector<std::size_t> set = {}) {
    if (set.size() == room)
        return;
    for (std::size_t k = set.empty() ? 0 : set.back() + 1; k < count; ++k) {
        std::vector<std::size_t> larger = set;
        larger.push_back(k);
        if (visit(larger))
            for_each_set(count, room, visit, std::move(larger));
    }
}

/// Steps 1 to 5 of docs/diagnosis.md, "How it decides". The log evidence of models is predicted
/// about the best model so far (linear_evidence.hpp), and models that may be as likely are fitted.
///
/// The result does not depend on the number of ranks or the order of the candidates. Throws
/// core::NumericalError if the published chain cannot be fitted, run::Abandoned if the heartbeat
/// says so.
[[nodiscard]] SearchResult search_models(std::span<const measure::Measurement> recordings,
                                         const DiagnosisOptions& options);

} // namespace culm::diagnose
