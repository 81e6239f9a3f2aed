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

/// Models that are fitted at once: it keeps two ranks busy, and a third of them wait for nothing.
constexpr std::size_t models_per_round = 2;
/// Share of the best gain: predictions across a large misfit are accurate to a tenth.
constexpr double close_share = 0.9;
/// The search ends after this number of models; the rest is recorded.
constexpr std::size_t most_visited = 40;
/// A fit whose log evidence is this far below its prediction may be in a wrong minimum.
constexpr double disappointing = 10.0;
constexpr int most_noise_estimates = 2;

struct Prediction : UnvisitedModel {
    std::vector<std::size_t> candidates; ///< added to the model about which it was made
    PredictedGain gain;
};

class Search {
  public:
    Search(std::span<const measure::Measurement> recordings, const DiagnosisOptions& options)
        : measured_(recordings), options_(options) {
        options_.report("fitting the published chain");
        baseline_ = fit::fit_baseline(recordings, options.candidate);
        if (baseline_.fit.failed())
            throw core::NumericalError(core::FailureKind::FitFailed,
                                       "the model cannot be fitted: " + baseline_.fit.reason);
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
        out.stated_best =
            fit::as_stated(base_fit_, baseline_.stated, baseline_.recordings, options_.candidate);
        out.recordings = std::move(baseline_.recordings);
        out.baseline = std::move(baseline_.fit);
        out.stated_baseline = std::move(baseline_.stated);
        out.best = base_;
        out.visited = std::move(visited_);
        out.noise = noise_scale_of(out.visited[base_].fit);
        out.best_fit = std::move(base_fit_);
        out.views = std::move(views_);
        out.stacked = std::move(stacked_);
        out.runs = runs_;
        return out;
    }

  private:
    void visit_first() {
        visited_.clear();
        fit::Fit first = baseline_.fit;
        if (!options_.known.empty())
            first = fit::fit_with_parts(options_.known, baseline_.fit, baseline_.recordings,
                                        options_.candidate);
        if (first.failed())
            throw core::NumericalError(core::FailureKind::FitFailed,
                                       "the model cannot be fitted: " + first.reason);
        runs_ += first.runs;
        add_visited(
            {fit::numbers_of(first), evidence_of(first, baseline_.recordings, options_.known)});
        set_base(0, std::move(first));
    }

    void add_visited(FittedModel model, double predicted = not_predicted) {
        const auto known = visited(model.fit.effects);
        const bool is_new = known == visited_.end();
        if (!is_new &&
            (model.fit.failed() ||
             (!known->fit.failed() && fit::deviance(model.fit) >= fit::deviance(known->fit))))
            return;
        VisitedModel& added = is_new ? visited_.emplace_back() : *known;
        added.fit = std::move(model.fit);
        added.evidence = std::move(model.evidence);
        added.predicted = predicted;
        if (visited_.size() == 1)
            noise_ = noise_as_assumed(added.fit);
        const bool is_eligible = !added.fit.failed() && added.evidence.absent_effects.empty();
        added.log_evidence = is_eligible ? log_evidence(added.evidence, noise_)
                                         : -std::numeric_limits<double>::infinity();
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
                set_base(now, fit::restored(visited_[now].fit, baseline_.recordings,
                                            options_.candidate));
            std::vector<PlannedModel> planned = models_found_by_larger_ones();
            if (planned.empty())
                planned = disappointing_models();
            if (planned.empty())
                planned = smaller_models();
            if (planned.empty()) {
                predict();
                planned = likeliest_unvisited();
            }
            // A model that is not expected to be the best is judged by the noise about the best
            // one. So are additions to a model whose residual is already at the noise.
            if ((!is_better_expected(planned) || is_at_noise(visited_[base_].fit)) &&
                estimate_noise_again())
                continue;
            if (planned.empty())
                return;
            visit(planned);
        }
    }

    [[nodiscard]] bool is_better_expected(const std::vector<PlannedModel>& planned) const {
        return std::ranges::any_of(planned, [&](const PlannedModel& each) {
            return !(each.predicted <= visited_[base_].log_evidence); // or is not predicted
        });
    }

    void set_base(std::size_t place, fit::Fit fit) {
        base_ = place;
        base_fit_ = std::move(fit);
        is_far_ =
            leaves_too_much(base_fit_, reference().fit, baseline_.recordings, options_.policy);
        linear_.reset();
    }

    /// The misfit that the search explains is that of the published chain; if the chain does not
    /// move, that of the likeliest model with one effect.
    [[nodiscard]] const VisitedModel& reference() const {
        const VisitedModel* reference = &visited_.front();
        if (!baseline_.fit.moves())
            for (const VisitedModel& each : visited_)
                if (each.fit.effects.size() == options_.known.size() + 1 &&
                    each.log_evidence > reference->log_evidence)
                    reference = &each;
        return *reference;
    }

    // --- Models that may have ended in a wrong minimum

    /// A model whose fit ended with some effects absent is a fit of the model without these
    /// effects. It provides their start if their own fit ended far below it or was not made.
    [[nodiscard]] std::vector<PlannedModel> models_found_by_larger_ones() {
        std::vector<PlannedModel> planned;
        for (const VisitedModel& larger : visited_) {
            if (larger.evidence.absent_effects.empty() || larger.fit.failed())
                continue;
            const fit::Fit smaller = without(larger.fit, larger.evidence.absent_effects);
            const double expected = reached(larger);
            const auto own = visited(smaller.effects);
            const bool is_near = own != visited_.end() && reached(*own) > expected - disappointing;
            if (!is_near && expected > least_wanted(smaller.effects) &&
                repeated_.insert(key_of(smaller.effects)).second)
                planned.push_back(
                    {smaller.effects, expected,
                     fit::models_of(smaller, baseline_.recordings, options_.candidate)});
        }
        return planned;
    }

    /// Models far below their prediction, if the prediction is still near the best. A best model
    /// that is far from the data is not repeated.
    [[nodiscard]] std::vector<PlannedModel> disappointing_models() {
        std::vector<PlannedModel> planned;
        for (const VisitedModel& model : visited_)
            if (!(is_far_ && &model == &visited_[base_]) &&
                model.predicted > least_wanted(model.fit.effects) &&
                reached(model) < model.predicted - disappointing && !is_at_noise(model.fit) &&
                repeated_.insert(key_of(model.fit.effects)).second)
                planned.push_back({model.fit.effects, model.predicted, {}});
        return planned;
    }

    /// Log evidence of the fit, even if one of its effects ended where it is absent.
    [[nodiscard]] double reached(const VisitedModel& model) const {
        return model.fit.failed() ? model.log_evidence : log_evidence(model.evidence, noise_);
    }

    /// Log evidence from which a model is worth a fit. The residual of the best model is noise to
    /// all models. If that residual has structure, models that explain nearly as much are rivals,
    /// except the larger ones that contain the best model.
    [[nodiscard]] double least_wanted(const fit::SelectedEffects& effects) const {
        const VisitedModel& best = visited_[base_];
        // The rivals of a best model that is far from the data are not answers either.
        if (is_far_) {
            const double noise =
                best.fit.is_noise_known_anywhere() ? static_cast<double>(best.fit.readings) : 0.0;
            return best.log_evidence + 0.5 * options_.policy.immaterial_share *
                                           std::max(0.0, best.fit.chi_squared - noise);
        }
        if (!best.fit.effects.empty() && contains_all(effects, best.fit.effects))
            return best.log_evidence - options_.policy.unvisited_margin;
        const double gain = std::max(0.0, best.log_evidence - reference().log_evidence);
        return best.log_evidence - (is_at_noise(best.fit) ? 0.0 : (1.0 - close_share) * gain) -
               options_.policy.unvisited_margin * noise_scale_of(best.fit).mean_known();
    }

    // --- Models with one effect less, a special law, or an effect absent from a recording

    [[nodiscard]] std::vector<PlannedModel> smaller_models() {
        std::vector<PlannedModel> planned;
        for (const fit::SelectedEffects& smaller :
             sets_to_compare(visited_[base_].fit, baseline_.recordings, options_.known.size(),
                             options_.candidates))
            if (!is_visited(smaller))
                planned.push_back(plan_for(smaller));
        return planned;
    }

    /// Starts from the model's fit with another noise or from the linear estimate; from all starts
    /// if that estimate was made about another model.
    [[nodiscard]] PlannedModel plan_for(const fit::SelectedEffects& effects) const {
        const ModelKey key = key_of(effects);
        PlannedModel plan{effects, not_predicted, {}};
        if (const auto found = predictions_.find(key); found != predictions_.end()) {
            const Prediction& prediction = found->second;
            plan.predicted = prediction.log_evidence;
            if (prediction.base == base_ && linear_)
                plan.start = start_at_estimate(base_fit_, baseline_.recordings, views_, *linear_,
                                               prediction.candidates, prediction.gain);
        }
        for (const VisitedModel& before : visited_before_)
            if (key_of(before.fit.effects) == key && !before.fit.failed())
                plan.start = fit::models_of(before.fit, baseline_.recordings, options_.candidate);
        return plan;
    }

    // --- Models with more effects

    void compute_columns() {
        stacked_ =
            readings_to_compare(base_fit_, baseline_.recordings, options_.candidate.heartbeat);
        views_.clear();
        std::vector<double> costs;
        for (const physics::SelectedEffect& candidate : options_.candidates) {
            fit::SelectedEffects larger = base_fit_.effects;
            larger.push_back(candidate);
            if (fit::contains(base_fit_.effects, candidate) || !can_be_combined(larger))
                continue;
            views_.push_back({candidate, {}});
            costs.push_back(fit::relative_cost(larger));
        }
        options_.report(fmt::format("computing the effects of {} candidates about {}",
                                    views_.size(), fmt::join(base_fit_.names, " + ")));
        std::vector<EffectColumns> answers =
            options_.map.values(costs, [&](std::size_t item, const run::Heartbeat& heartbeat) {
                return effect_columns(base_fit_, stacked_, views_[item].effect,
                                      baseline_.recordings,
                                      with_heartbeat(options_.candidate, heartbeat));
            });
        for (std::size_t k = 0; k < views_.size(); ++k)
            views_[k].columns = std::move(answers[k]);
        linear_.emplace(stacked_, views_);
    }

    /// Is the misfit of the best model so large that its residual is not noise and predictions
    /// about it are rough?
    [[nodiscard]] bool is_rough() const {
        const auto readings = static_cast<double>(std::max<std::size_t>(base_fit_.readings, 1));
        return base_fit_.chi_squared > options_.policy.rough_misfit * readings;
    }

    void predict() {
        if (linear_)
            return;
        compute_columns();
        // About a worse model, sets of several effects were predicted across a larger misfit.
        std::erase_if(predictions_, [&](const auto& entry) {
            return entry.second.base != base_ && entry.second.candidates.size() > 1;
        });
        const std::size_t added = base_fit_.effects.size() - options_.known.size();
        std::size_t room = options_.most_effects > added ? options_.most_effects - added : 0;
        if (is_rough())
            room = std::min<std::size_t>(room, 1);
        for_each_set(views_.size(), room, [&](const auto& set) { return predict_set(set); });
    }

    /// False if no model has these additions.
    bool predict_set(const std::vector<std::size_t>& set) {
        UnvisitedModel model{base_fit_.effects, visited_[base_].log_evidence, base_, {}, {}};
        for (const std::size_t each : set) {
            model.effects.push_back(views_[each].effect);
            model.added.push_back(views_[each].effect.effect->name());
        }
        if (!views_[set.back()].columns.failure.empty() || !can_be_combined(model.effects))
            return false;
        PredictedGain gain = linear_->gain(set);
        model.log_evidence += gain.log_evidence;
        model.falls = gain.falls;
        Prediction& entry = predictions_[key_of(model.effects)];
        entry = {std::move(model), set, std::move(gain)};
        return true;
    }

    /// Models that may be as likely as the best visited model.
    [[nodiscard]] std::vector<PlannedModel> likeliest_unvisited() {
        std::vector<PlannedModel> planned;
        std::vector<const Prediction*> likely;
        for (const auto& [key, prediction] : predictions_)
            if (prediction.log_evidence > least_wanted(prediction.effects) &&
                !is_visited(prediction.effects) && !is_explanation_of_base(prediction))
                likely.push_back(&prediction);
        std::ranges::stable_sort(likely, std::greater{},
                                 [](const Prediction* each) { return each->log_evidence; });
        const double here = visited_[base_].log_evidence;
        while (likely.size() > models_per_round)
            likely.pop_back();
        for (const Prediction* each : likely) {
            const fit::SelectedEffects& next = first_to_fit(*each).effects;
            const bool is_close =
                each->log_evidence - here > close_share * (likely.front()->log_evidence - here) -
                                                options_.policy.unvisited_margin;
            if (planned.empty() || (is_close && key_of(planned.front().effects) != key_of(next)))
                planned.push_back(plan_for(next));
        }
        return planned;
    }

    /// Are the added effects of a rival immaterial? They are removed from an answer, which then is
    /// the explanation of the base of the prediction.
    [[nodiscard]] bool is_explanation_of_base(const Prediction& model) const {
        const fit::Fit& best = visited_[base_].fit;
        if (is_at_noise(best) || contains_all(model.effects, best.effects))
            return false;
        const double before =
            visited_.front().fit.chi_squared - visited_[model.base].fit.chi_squared;
        return std::ranges::max(model.falls) <
               std::pow(options_.policy.immaterial_share, 2) * before;
    }

    /// The model itself, if a model with one effect less was fitted; else the likeliest of these. A
    /// fit that adds several effects at once from a linear estimate may follow a wrong valley.
    [[nodiscard]] const Prediction& first_to_fit(const Prediction& model) {
        const Prediction* likeliest = nullptr;
        for (const std::string& name : model.added) {
            fit::SelectedEffects part = model.effects;
            std::erase_if(part, [&](const auto& each) { return each.effect->name() == name; });
            if (is_visited(part))
                return model;
            const auto found = predictions_.find(key_of(part));
            if (found != predictions_.end() &&
                (likeliest == nullptr || found->second.log_evidence > likeliest->log_evidence))
                likeliest = &found->second;
        }
        return likeliest == nullptr ? model : first_to_fit(*likeliest);
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
                   : fit::restored(likeliest->fit, baseline_.recordings, options_.candidate);
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
                                   baseline_.recordings, options_.known,
                                   with_heartbeat(options_.candidate, heartbeat));
            });
        for (std::size_t k = 0; k < planned.size(); ++k) {
            if (!planned[k].start)
                repeated_.insert(key_of(planned[k].effects));
            FittedModel model = std::move(answers[k]);
            model.fit.effects = planned[k].effects;
            runs_ += model.fit.runs;
            add_visited(std::move(model), planned[k].predicted);
        }
    }

    // --- Noise about the best model

    /// Fits the likeliest models again with the noise about the best one; returns false if the
    /// noise is unchanged.
    [[nodiscard]] bool estimate_noise_again() {
        if (base_fit_.effects.empty() || is_rough() || noise_estimates_ == most_noise_estimates ||
            key_of(base_fit_.effects) == noise_about_)
            return false;
        noise_about_ = key_of(base_fit_.effects);
        ++noise_estimates_;
        std::optional<fit::BaselineFit> again =
            fit::baseline_beside_noise_of(base_fit_, baseline_, measured_, options_.candidate);
        if (!again || again->fit.failed())
            return false;
        options_.report("fitting the best model with the noise about it");
        const fit::SelectedEffects effects = base_fit_.effects;
        visited_before_ = visited_;
        const double before = visited_.front().log_evidence;
        const double chi_squared = baseline_.fit.chi_squared;
        baseline_ = *std::move(again);
        repeated_.clear();
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
    std::set<ModelKey> repeated_; ///< fitted from all starts, or from a larger model
    NoiseScale noise_;
    std::size_t base_ = 0; ///< the model about which everything is predicted
    fit::Fit base_fit_;
    bool is_far_ = false; ///< does the base leave more of the misfit than an answer may?
    StackedReadings stacked_;
    std::vector<CandidateView> views_;
    std::optional<LinearEvidence> linear_; ///< of `views_`; empty: not computed about this model
    ModelKey noise_about_;                 ///< the model about which the noise was estimated last
    int noise_estimates_ = 0;
    int runs_ = 0;
};

} // namespace

SearchResult search_models(std::span<const measure::Measurement> recordings,
                           const DiagnosisOptions& options) {
    return Search(recordings, options).run();
}

} // namespace culm::diagnose
