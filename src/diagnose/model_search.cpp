// SPDX-License-Identifier: BSD-3-Clause
#include "diagnose/model_search.hpp"

#include "core/error.hpp"
#include "diagnose/adequacy.hpp"
#include "diagnose/evidence/log_evidence.hpp"
#include "diagnose/planned_model.hpp"
#include "fit/fit_numbers.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include <fmt/core.h>
#include <fmt/ranges.h>

namespace culm::diagnose {
namespace {

/// Number of models fitted concurrently; two keep two ranks busy.
constexpr std::size_t models_per_round = 2;
/// Relative accuracy of predictions across a large misfit.
constexpr double predicted_within = 0.1;
constexpr double rough_within = 0.4; ///< across one above Policy::rough_misfit
/// The search ends after this number of models; the rest is recorded.
constexpr std::size_t most_visited = 40;
constexpr int most_noise_estimates = 2;

struct Prediction : UnvisitedModel {
    std::vector<std::size_t> candidates; ///< added to the model about which it was made
    PredictedGain gain;
};

/// A fitted model with the effects of all candidates about it.
struct Linearised {
    std::vector<CandidateView> views;
    std::optional<LinearEvidence> linear; ///< of `views`
};

/// The likeliest model with one effect beyond the `known` ones, of `within` unless that is null.
std::optional<std::size_t> likeliest_single(const std::vector<VisitedModel>& visited,
                                            std::size_t known, const fit::SelectedEffects* within) {
    std::optional<std::size_t> single;
    for (std::size_t k = 1; k < visited.size(); ++k)
        if (visited[k].fit.effects.size() == known + 1 && std::isfinite(visited[k].log_evidence) &&
            (within == nullptr || contains_all(*within, visited[k].fit.effects)) &&
            (!single || visited[k].log_evidence > visited[*single].log_evidence))
            single = k;
    return single;
}

class Search {
  public:
    Search(std::span<const measure::Measurement> recordings, const DiagnosisOptions& options)
        : measured_(recordings), options_(options) {
        options_.report("fitting the published chain");
        baseline_ = fit::fit_baseline(recordings, options.candidate);
        visit_first();
    }

    [[nodiscard]] SearchResult run() {
        explore();
        predict();
        SearchResult out;
        for (auto& [key, prediction] : predictions_)
            if (std::isfinite(prediction.log_evidence) && !is_visited(prediction.effects))
                out.unvisited.push_back(std::move(prediction));
        std::ranges::stable_sort(out.unvisited, std::greater{}, &UnvisitedModel::log_evidence);
        out.chain = std::move(baseline_);
        out.best = base_;
        out.visited = std::move(visited_);
        out.noise = noise_scale_of(out.visited[base_].fit);
        out.best_fit = std::move(base_fit_);
        out.views = std::move(about_->views);
        out.batches = batches_;
        out.is_complete = is_complete_;
        return out;
    }

  private:
    void visit_first() {
        visited_.clear();
        fit::Fit first = first_model(baseline_, options_);
        batches_ += first.batches;
        add_visited(
            {fit::to_numbers(first), evidence_of(first, baseline_.recordings, options_.known)});
        set_base(0, std::move(first));
    }

    void add_visited(FittedModel model) {
        VisitedModel& added = visited_.emplace_back(VisitedModel{std::move(model)});
        if (visited_.size() == 1)
            noise_ = noise_as_assumed(added.fit);
        added.judge(noise_);
    }

    [[nodiscard]] std::vector<VisitedModel>::iterator visited(const fit::SelectedEffects& effects) {
        return std::ranges::find(visited_, key_of(effects),
                                 [](const VisitedModel& each) { return key_of(each.fit.effects); });
    }

    [[nodiscard]] bool is_visited(const fit::SelectedEffects& effects) {
        return visited(effects) != visited_.end();
    }

    void explore() {
        while (visited_.size() < most_visited) {
            const auto likeliest =
                std::ranges::max_element(visited_, {}, &VisitedModel::log_evidence);
            if (const auto now = static_cast<std::size_t>(likeliest - visited_.begin());
                now != base_)
                set_base(now,
                         fit::rerun(visited_[now].fit, baseline_.recordings, options_.candidate));
            std::vector<PlannedModel> planned = smaller_models();
            if (planned.empty()) {
                predict();
                planned = likeliest_unvisited();
            }
            if (planned.empty()) {
                predict_swaps();
                planned = likeliest_unvisited();
            }
            // A model that is not expected to be the best is judged by the noise about the best
            // one. So are additions to a model whose residual is already at the noise.
            const bool is_better_expected = std::ranges::any_of(planned, [&](const auto& each) {
                return !(each.predicted <= visited_[base_].log_evidence); // or is not predicted
            });
            if ((!is_better_expected || is_at_noise(visited_[base_].fit)) && estimate_noise_again())
                continue;
            if (planned.empty())
                return;
            visit(planned);
        }
        is_complete_ = false;
    }

    void set_base(std::size_t place, fit::Fit fit) {
        base_ = place;
        base_fit_ = std::move(fit);
        is_far_ =
            leaves_too_much(base_fit_, reference().fit, baseline_.recordings, options_.policy);
        about_.reset();
    }

    /// The misfit that the search explains is that of the published chain; if the chain does not
    /// move, that of the likeliest model with one effect.
    [[nodiscard]] const VisitedModel& reference() const {
        const auto single = baseline_.fit.moves()
                                ? std::nullopt
                                : likeliest_single(visited_, options_.known.size(), nullptr);
        return visited_[single.value_or(0)];
    }

    /// Log evidence from which a model is worth a fit: near the best one. Predictions about a rough
    /// model are within a factor of two, those about another one whose residual has structure
    /// within a tenth. If the best model leaves too much for an answer, a larger one must explain a
    /// share of that.
    [[nodiscard]] double least_wanted(const Prediction& model) const {
        const VisitedModel& best = visited_[base_];
        const double gain = best.log_evidence - reference().log_evidence;
        if (model.base == 0 && base_ != 0 && is_rough(visited_.front().fit))
            return best.log_evidence - rough_within * gain;
        if (is_far_)
            return best.log_evidence +
                   0.5 * options_.policy.immaterial_share *
                       std::max(0.0, best.fit.chi_squared - static_cast<double>(best.fit.readings));
        const double margin =
            options_.policy.unvisited_margin * noise_scale_of(best.fit).mean_known();
        return best.log_evidence - (model.base == base_ || is_at_noise(best.fit)
                                        ? margin
                                        : std::max(margin, predicted_within * gain));
    }

    // --- Models with one effect less, or an effect absent from a recording

    [[nodiscard]] std::vector<PlannedModel> smaller_models() {
        std::vector<PlannedModel> planned;
        for (const fit::SelectedEffects& smaller :
             sets_to_compare(visited_[base_].fit, baseline_.recordings, options_.known.size()))
            if (!is_visited(smaller))
                planned.push_back(plan_for(smaller));
        return planned;
    }

    /// Starts from the model's fit with another noise or from the estimate that predicted it.
    [[nodiscard]] PlannedModel plan_for(const fit::SelectedEffects& effects) const {
        const ModelKey key = key_of(effects);
        PlannedModel plan{effects, not_predicted, {}};
        if (const auto found = predictions_.find(key); found != predictions_.end()) {
            const Prediction& prediction = found->second;
            plan.predicted = prediction.log_evidence;
            if (prediction.base == base_ && about_)
                plan.starts = starts_to_estimate(base_fit_, baseline_.recordings, about_->views,
                                                 prediction.candidates, prediction.gain);
        }
        for (const VisitedModel& before : visited_before_)
            if (key_of(before.fit.effects) == key && !before.fit.failed())
                plan.starts = {
                    fit::models_of(before.fit, baseline_.recordings, options_.candidate)};
        return plan;
    }

    // --- Models with more effects

    [[nodiscard]] Linearised linearised_about(const fit::Fit& fit) const {
        Linearised about;
        std::vector<double> costs;
        for (const physics::SelectedEffect& candidate : options_.candidates) {
            fit::SelectedEffects larger = fit.effects;
            larger.push_back(candidate);
            if (fit::contains(fit.effects, candidate) || !can_be_combined(larger))
                continue;
            about.views.push_back({candidate, {}});
            costs.push_back(fit::relative_cost(larger));
        }
        options_.report(fmt::format("computing the effects of {} candidates about {}",
                                    about.views.size(), fmt::join(fit.names(), " + ")));
        std::vector<EffectColumns> answers =
            options_.map.values(costs, [&](std::size_t item, const run::Heartbeat& heartbeat) {
                return effect_columns(fit, about.views[item].effect, baseline_.recordings,
                                      with_heartbeat(options_.candidate, heartbeat));
            });
        for (std::size_t k = 0; k < about.views.size(); ++k)
            about.views[k].columns = std::move(answers[k]);
        about.linear.emplace(fit.system, about.views);
        return about;
    }

    /// Is the misfit of the model so large that predictions about it are rough?
    [[nodiscard]] bool is_rough(const fit::Fit& fit) const {
        return fit.chi_squared > options_.policy.rough_misfit * static_cast<double>(fit.readings);
    }

    void predict() {
        if (about_)
            return;
        about_ = linearised_about(base_fit_);
        swapped_.insert(key_of(base_fit_.effects));
        // About a worse model, sets of several effects were predicted across a larger misfit.
        std::erase_if(predictions_, [&](const auto& entry) {
            return entry.second.base != base_ && entry.second.candidates.size() > 1;
        });
        const std::size_t added = base_fit_.effects.size() - options_.known.size();
        std::size_t room = options_.most_effects > added ? options_.most_effects - added : 0;
        if (is_rough(base_fit_))
            room = std::min<std::size_t>(room, 1);
        for_each_set(about_->views.size(), room, [&](const auto& set) {
            return predict_set(*about_, base_fit_.effects, base_, set);
        });
    }

    /// Predicts the additions to the visited model `base`, which has these effects and was
    /// linearised; false if no model has these additions.
    bool predict_set(const Linearised& about, const fit::SelectedEffects& effects, std::size_t base,
                     const std::vector<std::size_t>& set) {
        UnvisitedModel model{effects, visited_[base].log_evidence, base, {}, {}};
        for (const std::size_t each : set) {
            model.effects.push_back(about.views[each].effect);
            model.added.push_back(about.views[each].effect.effect->name());
        }
        if (!about.views[set.back()].columns.failure.empty() || !can_be_combined(model.effects))
            return false;
        PredictedGain gain = about.linear->gain(set);
        model.log_evidence += gain.log_evidence;
        if (!gain.points.empty())
            for (const PlacedEffect& effect : gain.points.front().effects)
                model.falls.push_back(effect.fall);
        Prediction& entry = predictions_[key_of(model.effects)];
        entry = {std::move(model), set, std::move(gain)};
        return true;
    }

    /// Predicts the models in which another effect stands in the place of one of the best model's.
    /// A swap is a single addition to the model without that effect, which was fitted.
    void predict_swaps() {
        const fit::SelectedEffects effects = base_fit_.effects;
        for (std::size_t k = options_.known.size(); k < effects.size(); ++k) {
            fit::SelectedEffects smaller = effects;
            smaller.erase(smaller.begin() + static_cast<std::ptrdiff_t>(k));
            const auto found = visited(smaller);
            if (found == visited_.end() || found->fit.failed() || !found->fit.moves() ||
                !swapped_.insert(key_of(smaller)).second)
                continue;
            const auto base = static_cast<std::size_t>(found - visited_.begin());
            const Linearised about = linearised_about(
                base == 0 && options_.known.empty()
                    ? baseline_.fit
                    : fit::rerun(found->fit, baseline_.recordings, options_.candidate));
            for (std::size_t each = 0; each < about.views.size(); ++each) {
                fit::SelectedEffects swapped = smaller;
                swapped.push_back(about.views[each].effect);
                if (!is_visited(swapped))
                    predict_set(about, smaller, base, {each});
            }
        }
    }

    /// Models that may be as likely as the best visited model; the smallest come first, because
    /// they are the bases of better predictions.
    [[nodiscard]] std::vector<PlannedModel> likeliest_unvisited() {
        std::vector<const Prediction*> likely;
        for (const auto& [key, prediction] : predictions_)
            if (prediction.log_evidence > least_wanted(prediction) &&
                !is_visited(prediction.effects))
                likely.push_back(&prediction);
        std::ranges::sort(likely, {}, [](const Prediction* each) {
            return std::pair(each->effects.size(), -each->log_evidence);
        });
        std::vector<PlannedModel> planned;
        for (const Prediction* each : likely)
            if (planned.size() < models_per_round &&
                each->effects.size() == likely.front()->effects.size())
                planned.push_back(plan_for(each->effects));
        return planned;
    }

    // --- Fits

    /// The likeliest model that was fitted and has some of the effects.
    [[nodiscard]] fit::Fit likeliest_within(const fit::SelectedEffects& effects) const {
        const VisitedModel* likeliest = &visited_.front();
        for (const VisitedModel& each : visited_)
            if (each.fit.effects.size() < effects.size() &&
                each.log_evidence > likeliest->log_evidence &&
                contains_all(effects, each.fit.effects))
                likeliest = &each;
        return likeliest == &visited_.front() && options_.known.empty()
                   ? baseline_.fit
                   : fit::rerun(likeliest->fit, baseline_.recordings, options_.candidate);
    }

    void visit(const std::vector<PlannedModel>& planned) {
        std::vector<std::string> names;
        std::vector<double> costs;
        for (const PlannedModel& model : planned) {
            names.push_back(fmt::format(
                "{}", fmt::join(fit::model_names(fit::in_library_order(model.effects)), " + ")));
            costs.push_back(fit::relative_cost(model.effects));
        }
        options_.report(fmt::format("fitting {}", fmt::join(names, "; ")));
        std::vector<FittedModel> answers =
            options_.map.values(costs, [&](std::size_t item, const run::Heartbeat& heartbeat) {
                return fit_planned(planned[item], likeliest_within(planned[item].effects),
                                   baseline_.recordings, options_.known, options_.policy,
                                   with_heartbeat(options_.candidate, heartbeat));
            });
        for (std::size_t k = 0; k < planned.size(); ++k) {
            FittedModel model = std::move(answers[k]);
            model.fit.effects = planned[k].effects;
            batches_ += model.fit.batches;
            add_visited(std::move(model));
        }
    }

    // --- Noise about the best model

    /// Fits the likeliest models again with the noise about the best one; returns false if the
    /// noise is unchanged.
    [[nodiscard]] bool estimate_noise_again() {
        if (base_fit_.effects.empty() || is_rough(base_fit_) || is_far_ ||
            noise_estimates_ == most_noise_estimates || key_of(base_fit_.effects) == noise_about_)
            return false;
        noise_about_ = key_of(base_fit_.effects);
        ++noise_estimates_;
        std::optional<fit::BaselineFit> again =
            fit::baseline_with_noise_about(base_fit_, baseline_, measured_, options_.candidate);
        if (!again || again->fit.failed())
            return false;
        options_.report("fitting the best model with the noise about it");
        const fit::SelectedEffects effects = base_fit_.effects;
        visited_before_ = visited_;
        const double before = visited_.front().log_evidence;
        const double chi_squared = baseline_.fit.chi_squared;
        baseline_ = *std::move(again);
        std::erase_if(swapped_, [&](const ModelKey& key) { // predictions about the chain remain
            return key != key_of(options_.known);
        });
        visit_first();
        // χ² of predictions about the chain is nearly proportional to the chain's own χ².
        const double ratio = baseline_.fit.chi_squared / chi_squared;
        std::erase_if(predictions_, [](const auto& entry) { return entry.second.base != 0; });
        for (auto& [key, prediction] : predictions_)
            prediction.log_evidence =
                visited_.front().log_evidence + ratio * (prediction.log_evidence - before);
        PlannedModel best = plan_for(effects);
        best.predicted = not_predicted;
        visit({best});
        return true;
    }

    std::span<const measure::Measurement> measured_;
    const DiagnosisOptions& options_;
    fit::BaselineFit baseline_;
    std::vector<VisitedModel> visited_;
    std::vector<VisitedModel> visited_before_; ///< with a previous noise
    std::map<ModelKey, Prediction> predictions_;
    NoiseScale noise_;
    std::size_t base_ = 0; ///< the model about which everything is predicted
    fit::Fit base_fit_;
    bool is_far_ = false; ///< does the base leave more of the misfit than an answer may?
    std::optional<Linearised> about_; ///< the base; empty: not computed
    std::set<ModelKey> swapped_;      ///< models about which swaps were predicted
    ModelKey noise_about_;            ///< the model about which the noise was estimated last
    int noise_estimates_ = 0;
    int batches_ = 0;
    bool is_complete_ = true;
};

} // namespace

fit::Fit first_model(const fit::BaselineFit& baseline, const DiagnosisOptions& options) {
    fit::Fit first = baseline.fit;
    if (!first.failed() && !options.known.empty())
        first = fit_larger(options.known, baseline.fit, baseline.recordings, options.candidate);
    if (first.failed())
        throw core::NumericalError(core::FailureKind::FitFailed,
                                   "the model cannot be fitted: " + first.reason);
    return first;
}

void VisitedModel::judge(const NoiseScale& noise) {
    log_evidence = !fit.failed() && evidence.absent_effects.empty()
                       ? diagnose::log_evidence(evidence, noise)
                       : -std::numeric_limits<double>::infinity();
}

std::optional<std::size_t> likeliest_part(const SearchResult& search, std::size_t model,
                                          const DiagnosisOptions& options) {
    const fit::SelectedEffects& effects = search.visited[model].fit.effects;
    return effects.size() > options.known.size() + 1
               ? likeliest_single(search.visited, options.known.size(), &effects)
               : std::nullopt;
}

SearchResult search_models(std::span<const measure::Measurement> recordings,
                           const DiagnosisOptions& options) {
    return Search(recordings, options).run();
}

} // namespace culm::diagnose
