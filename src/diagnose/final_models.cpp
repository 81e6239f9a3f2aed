// SPDX-License-Identifier: BSD-3-Clause
#include "diagnose/final_models.hpp"

#include "diagnose/planned_model.hpp"
#include "diagnose/posterior.hpp"
#include "fit/fit_numbers.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

namespace culm::diagnose {
namespace {

/// Those that the answer may name or show: the likeliest model of each explanation, and the
/// likeliest one with a single effect of the answer.
std::set<std::size_t> rivals_of(const SearchResult& search, const DiagnosisOptions& options) {
    const Posterior posterior = posterior_of(search, options);
    const double least =
        std::exp(-options.policy.unvisited_margin) * posterior.explanations.front().probability;
    std::set<std::size_t> rivals{search.best, posterior.by_family.front().model};
    for (const Explanation& explanation : posterior.explanations)
        if (explanation.probability > least)
            rivals.insert(explanation.model);
    if (const auto part = likeliest_part(search, posterior.by_family.front().model, options))
        rivals.insert(*part);
    return rivals;
}

/// The search again with the number of spheres that the user stated, for the models that matter.
class FinalFits {
  public:
    FinalFits(const SearchResult& search, std::span<const measure::Measurement> recordings,
              const DiagnosisOptions& coarse, const DiagnosisOptions& options)
        : search_(search), coarse_(coarse), options_(options), out_(search) {
        out_.chain =
            fit::baseline_with_chain(search.chain, coarse.candidate, recordings, options.candidate);
        first_ = first_model(out_.chain, options);
        out_.visited.front().fit = fit::to_numbers(first_);
        out_.visited.front().evidence = evidence_of(first_, out_.chain.recordings, options.known);
        out_.batches += first_.batches;
    }

    /// Fits until the answer has no model with the coarse chain.
    [[nodiscard]] SearchResult run() {
        for (const SearchResult* now = &search_;; now = &out_) {
            std::set<std::size_t> wanted = rivals_of(*now, options_);
            std::erase_if(wanted, [&](std::size_t k) { return fitted_.contains(k); });
            if (wanted.empty() && now == &out_) {
                out_.best_fit = out_.best == 0 ? first_
                                               : fit::rerun(out_.best_fit, out_.chain.recordings,
                                                            options_.candidate);
                return std::move(out_);
            }
            fit({wanted.begin(), wanted.end()});
            judge();
        }
    }

  private:
    void fit(const std::vector<std::size_t>& models) {
        std::vector<double> costs;
        for (const std::size_t k : models)
            costs.push_back(fit::relative_cost(search_.visited[k].fit.effects));
        std::vector<FittedModel> found =
            options_.map.values(costs, [&](std::size_t item, const run::Heartbeat& heartbeat) {
                const fit::Fit& numbers = search_.visited[models[item]].fit;
                const PlannedModel planned{
                    numbers.effects,
                    not_predicted,
                    {fit::with_chain(numbers, search_.chain.recordings, coarse_.candidate,
                                     out_.chain.recordings, options_.candidate)}};
                return fit_planned(planned, first_, out_.chain.recordings, options_.known,
                                   options_.policy, with_heartbeat(options_.candidate, heartbeat));
            });
        for (std::size_t k = 0; k < models.size(); ++k) {
            VisitedModel& model = out_.visited[models[k]];
            found[k].fit.effects = model.fit.effects;
            out_.batches += found[k].fit.batches;
            static_cast<FittedModel&>(model) = std::move(found[k]);
            fitted_.insert(models[k]);
        }
    }

    /// The log evidence of all models and the best one. The models with the coarse chain keep
    /// their distance from the coarse search's best one.
    void judge() {
        const NoiseScale noise = noise_as_assumed(out_.visited.front().fit);
        const double offset = log_evidence(out_.visited[search_.best].evidence, noise) -
                              log_evidence(search_.visited[search_.best].evidence, noise);
        for (std::size_t k = 0; k < out_.visited.size(); ++k) {
            VisitedModel& model = out_.visited[k];
            model.evidence.offset = fitted_.contains(k) ? 0.0 : offset;
            model.judge(noise);
        }
        for (std::size_t k = 0; k < out_.unvisited.size(); ++k)
            out_.unvisited[k].log_evidence = search_.unvisited[k].log_evidence + offset;
        const auto best = std::ranges::max_element(out_.visited, {}, &VisitedModel::log_evidence);
        out_.best = static_cast<std::size_t>(best - out_.visited.begin());
        out_.noise = noise_scale_of(best->fit);
        out_.best_fit = best->fit;
    }

    const SearchResult& search_;
    const DiagnosisOptions& coarse_;
    const DiagnosisOptions& options_;
    SearchResult out_;
    fit::Fit first_;
    std::set<std::size_t> fitted_{0};
};

} // namespace

SearchResult with_stated_chain(const SearchResult& search,
                               std::span<const measure::Measurement> recordings,
                               const DiagnosisOptions& coarse, const DiagnosisOptions& options) {
    const int spheres = search.best_fit.parts.front().model.spec.stem.sphere_count;
    if (fit::chain_of(recordings.front(), options.candidate.chain).spec.stem.sphere_count ==
        spheres)
        return search;
    options.report("fitting the likeliest models with all spheres");
    return FinalFits(search, recordings, coarse, options).run();
}

} // namespace culm::diagnose
