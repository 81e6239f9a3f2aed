// SPDX-License-Identifier: BSD-3-Clause
// The models that compete for the answer, with the number of spheres that the user stated.
#include "diagnose/search/posterior.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <set>
#include <utility>
#include <vector>

namespace culm::diagnose {
namespace {

/// Those that the answer may name or show: the likeliest model of each explanation, and the
/// likeliest one with a single effect of the answer.
std::set<std::size_t> rivals_of(const SearchResult& search) {
    const Posterior posterior = posterior_of(search);
    // Fits of many stems take long: the models left out may not decide whether the answer has 95 %.
    const Policy& policy = search.stems->options().policy;
    const double least = (search.stems->is_one() ? std::exp(-policy.unvisited_margin)
                                                 : 1.0 - policy.held_probability) *
                         posterior.explanations.front().probability;
    const std::size_t answer = posterior.by_family.front().model;
    std::set<std::size_t> rivals{0, search.best, answer};
    for (const Explanation& explanation : posterior.explanations)
        if (explanation.probability > least)
            rivals.insert(explanation.model);
    if (const auto part = likeliest_part(search.visited, answer))
        rivals.insert(*part);
    return rivals;
}

/// The search again with the number of spheres that the user stated, for the models that matter.
class FinalFits {
  public:
    FinalFits(const SearchResult& coarse, const DiagnosisOptions& options)
        : coarse_(coarse), stems_(std::make_shared<Stems>(coarse.stems->with_chain(options))),
          out_(coarse), noise_(noise_of_search(*stems_, coarse.best_model())) {
        out_.stems = stems_;
        out_.fits = ModelFits(*stems_);
        fit({0});
        judge();
    }

    /// Fits until the answer has no model with the coarse chain.
    [[nodiscard]] SearchResult run() {
        for (const SearchResult* now = &coarse_;; now = &out_) {
            std::set<std::size_t> wanted = rivals_of(*now);
            std::erase_if(wanted, [&](std::size_t k) { return fitted_.contains(k); });
            if (wanted.empty() && now == &out_)
                return std::move(out_);
            fit(wanted);
            judge();
        }
    }

  private:
    void fit(const std::set<std::size_t>& models) {
        out_.fits.set_noise(noise_);
        std::vector<PlannedModel> planned;
        planned.reserve(models.size());
        for (const std::size_t k : models)
            planned.push_back(plan_for(k));
        out_.fits.fit(planned);
        auto fitted = planned.begin();
        for (const std::size_t k : models) {
            out_.visited[k] = std::move((fitted++)->model);
            out_.batches += out_.visited[k].batches();
            fitted_.insert(k);
        }
    }

    /// From the fit with the coarse chain.
    [[nodiscard]] PlannedModel plan_for(std::size_t k) const {
        PlannedModel plan;
        plan.model = coarse_.visited[k];
        plan.model.failure.clear();
        for (const std::size_t s : stems_->fitted()) {
            StemStart& start = plan.starts[s];
            const fit::Fit& numbers = coarse_.visited[k].stems[s].fit;
            if (numbers.effects.empty() || (k == 0 && stems_->is_one()))
                start.smaller = &(*stems_)[s].chain;
            else if (stems_->is_one())
                start.smaller = &out_.visited.front().stems[s].fit;
            if (k != 0 && numbers.moves() && !numbers.effects.empty())
                start.starts = [this, s, &numbers](const fit::Fit*,
                                                   const fit::FitOptions& options) {
                    const Stems& from = *coarse_.stems;
                    return std::vector<fit::StartModels>{
                        fit::with_chain(numbers, from[s].recordings, from.options().candidate,
                                        (*stems_)[s].recordings, options)};
                };
        }
        return plan;
    }

    /// The log evidence of all models and the best one. The models with the coarse chain keep
    /// their distance from the coarse search's best one.
    void judge() {
        out_.fits.set_noise(noise_);
        Model best = out_.visited[coarse_.best];
        best.offset = 0.0;
        out_.fits.judge(best);
        const double offset = best.log_evidence - coarse_.visited[coarse_.best].log_evidence;
        for (std::size_t k = 0; k < out_.visited.size(); ++k) {
            Model& model = out_.visited[k];
            if (fitted_.contains(k)) {
                model.offset = 0.0;
                out_.fits.judge(model);
            } else {
                model.offset = offset;
                model.log_evidence = coarse_.visited[k].log_evidence + offset;
            }
        }
        for (std::size_t k = 0; k < out_.unvisited.size(); ++k)
            out_.unvisited[k].log_evidence = coarse_.unvisited[k].log_evidence + offset;
        const auto best_place = std::ranges::max_element(out_.visited, {}, &Model::log_evidence);
        out_.best = static_cast<std::size_t>(best_place - out_.visited.begin());
        judge_about_best(out_);
    }

    const SearchResult& coarse_;
    std::shared_ptr<const Stems> stems_;
    SearchResult out_;
    std::vector<NoiseScale> noise_; ///< (stems)
    std::set<std::size_t> fitted_;
};

} // namespace

SearchResult with_stated_chain(const SearchResult& coarse, const DiagnosisOptions& options) {
    options.report("fitting the likeliest models with all spheres");
    return FinalFits(coarse, options).run();
}

} // namespace culm::diagnose
