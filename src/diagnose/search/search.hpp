// SPDX-License-Identifier: BSD-3-Clause
// Which models explain the stems: log evidence is predicted for all sets of effects and computed
// for the few that matter.
#pragma once

#include "diagnose/search/prediction.hpp"

#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace culm::diagnose {

/// Do more than half of the stems leave more of the misfit of `first` than an answer may?
[[nodiscard]] bool most_leave_too_much(const Stems& stems, const Model& model, const Model& first);

struct SearchResult {
    std::shared_ptr<const Stems> stems;
    std::vector<Model> visited;            ///< the published chain (with what is known) first
    std::vector<UnvisitedModel> unvisited; ///< the largest log evidence first
    std::size_t best = 0;                  ///< of the visited models
    ModelFits fits;                        ///< with the noise about the best model
    std::optional<Linearised> about;       ///< the best model
    int batches = 0;                       ///< of lanes that were run for the fits of models
    bool is_complete = true;               ///< false: it ended at the largest number of models
    std::vector<double> about_best{};      ///< (visited) log evidence with the noise about the best
    double noise_ratio = 1.0; ///< of that noise to the one by which models were searched

    [[nodiscard]] const Model& best_model() const { return visited[best]; }
    /// A stem's fit in a model, with residuals and derivatives.
    [[nodiscard]] fit::Fit rerun(std::size_t model, std::size_t stem) const;
};

/// The likeliest model with one of the effects of this one, if it has several.
[[nodiscard]] std::optional<std::size_t> likeliest_part(const std::vector<Model>& visited,
                                                        std::size_t model);

/// Steps 1 to 5 of docs/diagnosis.md, "How it decides". The log evidence of models is predicted
/// about the best model so far (linearised.hpp), and models that may be as likely are fitted.
///
/// The result does not depend on the number of ranks or the order of the candidates. Throws
/// core::NumericalError if the published chain cannot be fitted, run::Abandoned if the heartbeat
/// says so.
[[nodiscard]] SearchResult search_models(std::span<const Specimen> specimens,
                                         const DiagnosisOptions& options);

/// Noise by which the models of a search are judged. One stem counts with the noise that its fits
/// assume. Among several, a stem that the best model does not explain counts less than the others.
[[nodiscard]] std::vector<NoiseScale> noise_of_search(const Stems& stems, const Model& best);

/// Sets the noise about the best model and the log evidence of all models with it.
void judge_about_best(SearchResult& search);

/// The result of a search with a coarse chain whose rivals are fitted again with the chain of
/// `options`: the published chain, the best model, its likeliest part with one effect, and every
/// model that the answer may name. The others keep their numbers and their log evidence relative to
/// the best model. `about` remains that of the search.
[[nodiscard]] SearchResult with_stated_chain(const SearchResult& coarse,
                                             const DiagnosisOptions& options);

} // namespace culm::diagnose
