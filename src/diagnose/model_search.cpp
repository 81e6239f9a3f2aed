// SPDX-License-Identifier: BSD-3-Clause
#include "diagnose/model_search.hpp"

#include "core/error.hpp"
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
/// Of the best gain: predictions across a large misfit are good to a tenth.
constexpr double close_share = 0.9;
/// A search that has fitted so many models ends; what it left is recorded.
constexpr std::size_t most_visited = 40;
/// Log evidence below its prediction from which a fit may have ended in a wrong minimum.
constexpr double disappointing = 10.0;
/// Log evidence below what is wanted from which a model is not fitted again with another noise.
constexpr double hopeless = 40.0;
constexpr int most_noise_estimates = 2;

/// The numbers of the fit, without those of the effects `names`.
fit::Fit without(fit::Fit fit, const std::vector<std::string>& names) {
    const auto is_one = [&](const std::string& name) {
        return std::ranges::find(names, name) != names.end();
    };
    std::erase_if(fit.effects, [&](const auto& each) { return is_one(each.effect->name()); });
    std::erase_if(fit.parameters, [&](const auto& each) { return is_one(each.id.effect); });
    return fit;
}

struct Prediction {
    fit::SelectedEffects effects;
    double log_evidence = 0.0;
    std::vector<std::size_t> candidates; ///< added to the model about which it was made
    PredictedGain gain;
    std::size_t base = 0; ///< that model, among the visited ones
};

class Search {
  public:
    Search(std::span<const measure::Measurement> recordings, const SearchOptions& options,
           const Policy& policy)
        : measured_(recordings), options_(options), policy_(policy) {
        report("fitting the published chain");
        baseline_ = fit::fit_baseline(recordings, options.candidate);
        if (baseline_.fit.failed())
            throw core::NumericalError(core::FailureKind::FitFailed,
                                       "the model cannot be fitted: " + baseline_.fit.reason);
        visit_first();
    }

    [[nodiscard]] SearchResult run() {
        explore();
        return result();
    }

  private:
    void report(const std::string& next) const {
        if (options_.progress)
            options_.progress(next);
    }

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
        const ModelKey key = key_of(model.fit.effects);
        const auto known = std::ranges::find_if(
            visited_, [&](const VisitedModel& each) { return key_of(each.fit.effects) == key; });
        if (known != visited_.end() &&
            !(!model.fit.failed() &&
              (known->fit.failed() || fit::deviance(model.fit) < fit::deviance(known->fit))))
            return;
        VisitedModel& added = known != visited_.end() ? *known : visited_.emplace_back();
        added.fit = std::move(model.fit);
        added.evidence = std::move(model.evidence);
        added.predicted = predicted;
        if (visited_.size() == 1)
            noise_ = noise_as_assumed(added.fit);
        added.log_evidence = is_eligible(added) ? log_evidence(added.evidence, noise_)
                                                : -std::numeric_limits<double>::infinity();
    }

    [[nodiscard]] static bool is_eligible(const VisitedModel& model) {
        return !model.fit.failed() && model.evidence.absent_effects.empty();
    }

    [[nodiscard]] std::size_t best() const {
        return static_cast<std::size_t>(
            std::ranges::max_element(visited_, {}, &VisitedModel::log_evidence) - visited_.begin());
    }

    [[nodiscard]] bool is_visited(const fit::SelectedEffects& effects) const {
        const ModelKey key = key_of(effects);
        return std::ranges::any_of(
            visited_, [&](const auto& each) { return key_of(each.fit.effects) == key; });
    }

    void explore() {
        while (visited_.size() < most_visited) {
            if (const std::size_t now = best(); now != base_)
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
            if (planned.empty())
                planned = special_case();
            // What is not expected to be the best model is judged by the noise about that one. So
            // is what would explain a residual that is noise already.
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
        linear_.reset();
        stated_best_.reset();
    }

    // --- Models that may have ended in a wrong minimum

    /// A model whose fit ended where some of its effects are absent is a fit of the model without
    /// these. It is their start where their own fit ended far below or was not made.
    [[nodiscard]] std::vector<PlannedModel> models_found_by_larger_ones() {
        std::vector<PlannedModel> planned;
        for (const VisitedModel& larger : visited_) {
            if (larger.evidence.absent_effects.empty() || larger.fit.failed())
                continue;
            const fit::Fit smaller = without(larger.fit, larger.evidence.absent_effects);
            const ModelKey key = key_of(smaller.effects);
            const double expected = log_evidence(larger.evidence, noise_);
            const bool is_near = std::ranges::any_of(visited_, [&](const VisitedModel& each) {
                return key_of(each.fit.effects) == key && reached(each) > expected - disappointing;
            });
            if (!is_near && expected > least_wanted() && inherited_.insert(key).second)
                planned.push_back(
                    {smaller.effects, expected,
                     fit::models_of(smaller, baseline_.recordings, options_.candidate)});
        }
        return planned;
    }

    /// Those far below their prediction, if that is still near the best.
    [[nodiscard]] std::vector<PlannedModel> disappointing_models() {
        std::vector<PlannedModel> planned;
        const double least = least_wanted();
        for (const VisitedModel& model : visited_)
            if (model.predicted > least && reached(model) < model.predicted - disappointing &&
                !is_at_noise(model.fit) && repeated_.insert(key_of(model.fit.effects)).second)
                planned.push_back({model.fit.effects, model.predicted, {}});
        return planned;
    }

    /// Log evidence of the fit, even if one of its effects ended where it is absent.
    [[nodiscard]] double reached(const VisitedModel& model) const {
        return model.fit.failed() ? model.log_evidence : log_evidence(model.evidence, noise_);
    }

    /// Log evidence from which a model is worth a fit. What the best model lacks is noise to all;
    /// where that is structure, models that explain nearly as much are rivals.
    [[nodiscard]] double least_wanted() const {
        const double best = visited_[base_].log_evidence;
        const double rivals =
            is_at_noise(visited_[base_].fit)
                ? 0.0
                : (1.0 - close_share) * std::max(0.0, best - visited_.front().log_evidence);
        return best - rivals -
               policy_.unvisited_margin * noise_scale_of(visited_[base_].fit).mean_known();
    }

    /// Within three standard deviations of χ² for noise alone.
    [[nodiscard]] static bool is_at_noise(const fit::Fit& fit) {
        const auto readings = static_cast<double>(fit.readings);
        return fit.is_noise_known_everywhere() && !fit.failed() &&
               fit.chi_squared < readings + 3.0 * std::sqrt(2.0 * readings);
    }

    // --- Models with one effect less

    [[nodiscard]] std::vector<PlannedModel> smaller_models() const {
        const fit::SelectedEffects& effects = visited_[base_].fit.effects;
        std::vector<PlannedModel> planned;
        const auto plan = [&](fit::SelectedEffects smaller) {
            if (is_visited(smaller))
                return;
            fit::Fit start = visited_[base_].fit;
            start.effects = smaller;
            const double expected = predicted(smaller);
            planned.push_back({std::move(smaller), expected,
                               fit::models_of(start, baseline_.recordings, options_.candidate)});
        };
        for (std::size_t k = options_.known.size(); k < effects.size(); ++k) {
            if (effects.size() > options_.known.size() + 1) {
                fit::SelectedEffects smaller = effects;
                smaller.erase(smaller.begin() + static_cast<std::ptrdiff_t>(k));
                plan(std::move(smaller));
            }
            // What belongs to a recording (a mass at its tip) need not be in all of them.
            for (const measure::Measurement& recording : baseline_.recordings)
                if (may_leave(effects[k], recording.stem.id)) {
                    fit::SelectedEffects smaller = effects;
                    smaller[k].absent_from.push_back(recording.stem.id);
                    std::ranges::sort(smaller[k].absent_from);
                    plan(std::move(smaller));
                }
        }
        return planned;
    }

    [[nodiscard]] double predicted(const fit::SelectedEffects& effects) const {
        const auto found = predictions_.find(key_of(effects));
        return found == predictions_.end() ? not_predicted : found->second.log_evidence;
    }

    /// Is the effect absent from the recording, as far as its size there says?
    [[nodiscard]] bool may_leave(const physics::SelectedEffect& effect,
                                 const std::string& recording) const {
        if (!fit::belongs_to_recording({effect.effect->name(), {}, {}}) ||
            effect.absent_from.size() + 1 >= baseline_.recordings.size())
            return false;
        return std::ranges::any_of(
            visited_[base_].fit.parameters, [&](const fit::FittedParameter& parameter) {
                return parameter.id.effect == effect.effect->name() &&
                       parameter.id.recording == recording && !parameter.is_place &&
                       (is_absent(parameter) || parameter.is_at_bound);
            });
    }

    /// The best model with the law that a general one turned out to be.
    [[nodiscard]] std::vector<PlannedModel> special_case() const {
        fit::SelectedEffects effects = visited_[base_].fit.effects;
        for (physics::SelectedEffect& selected : effects) {
            const std::string name = special_case_of(*selected.effect, visited_[base_].fit);
            const auto found =
                std::ranges::find_if(options_.candidates, [&](const auto& candidate) {
                    return candidate.effect->name() == name;
                });
            if (found == options_.candidates.end() || found->effect == selected.effect)
                continue;
            const std::vector<std::string> absent_from = selected.absent_from;
            selected = *found;
            selected.absent_from = absent_from;
        }
        if (is_visited(effects))
            return {};
        return {{std::move(effects), not_predicted, {}}};
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
        report(fmt::format("computing the effects of {} candidates beside {}", views_.size(),
                           fmt::join(base_fit_.names, " + ")));
        std::vector<std::optional<EffectColumns>> answers =
            options_.map.values(costs, [&](std::size_t item, const run::Heartbeat& heartbeat) {
                return effect_columns(base_fit_, stacked_, views_[item].effect,
                                      baseline_.recordings,
                                      with_heartbeat(options_.candidate, heartbeat));
            });
        for (std::size_t k = 0; k < views_.size(); ++k) {
            EffectColumns lost;
            lost.failure = "the rank that computed it was lost";
            views_[k].columns = std::move(answers[k]).value_or(std::move(lost));
        }
        linear_.emplace(stacked_, views_);
    }

    void predict() {
        if (linear_)
            return;
        compute_columns();
        // About a worse model the sets of several were predicted across its larger misfit.
        std::erase_if(predictions_, [&](const auto& entry) {
            return entry.second.base != base_ && entry.second.candidates.size() > 1;
        });
        const double here = visited_[base_].log_evidence;
        const std::size_t added = base_fit_.effects.size() - options_.known.size();
        const bool is_rough = base_fit_.chi_squared >
                              policy_.rough_misfit *
                                  static_cast<double>(std::max<std::size_t>(base_fit_.readings, 1));
        std::size_t room = options_.most_effects > added ? options_.most_effects - added : 0;
        if (is_rough)
            room = std::min<std::size_t>(room, 1);
        std::vector<std::size_t> set;
        predict_sets(here, room, 0, set);
    }

    void predict_sets(double here, std::size_t room, std::size_t from,
                      std::vector<std::size_t>& set) {
        if (set.size() == room)
            return;
        for (std::size_t k = from; k < views_.size(); ++k) {
            if (!views_[k].columns.failure.empty())
                continue;
            set.push_back(k);
            fit::SelectedEffects effects = base_fit_.effects;
            for (const std::size_t each : set)
                effects.push_back(views_[each].effect);
            if (can_be_combined(effects)) {
                PredictedGain gain = linear_->gain(set);
                Prediction& entry = predictions_[key_of(effects)];
                entry = {std::move(effects), here + gain.log_evidence, set, std::move(gain), base_};
                predict_sets(here, room, k + 1, set);
            }
            set.pop_back();
        }
    }

    /// Those within the margin of the best visited model. A candidate of which no run could be
    /// computed has to be fitted to be judged.
    [[nodiscard]] std::vector<PlannedModel> likeliest_unvisited() {
        std::vector<PlannedModel> planned;
        for (const CandidateView& view : views_)
            if (!view.columns.failure.empty() && base_ == 0) {
                fit::SelectedEffects effects = base_fit_.effects;
                effects.push_back(view.effect);
                if (!is_visited(effects))
                    planned.push_back({std::move(effects), not_predicted, {}});
            }
        const double least = least_wanted();
        std::vector<const Prediction*> likely;
        for (const auto& [key, prediction] : predictions_)
            if (prediction.log_evidence > least && !is_visited(prediction.effects))
                likely.push_back(&prediction);
        std::ranges::stable_sort(likely, std::greater{},
                                 [](const Prediction* each) { return each->log_evidence; });
        for (std::size_t k = 0; k < std::min(models_per_round, likely.size()); ++k)
            if (k == 0 || is_close(*likely[k], *likely.front()))
                planned.push_back(
                    {likely[k]->effects, likely[k]->log_evidence, start_of(*likely[k])});
        return planned;
    }

    /// Does a prediction promise nearly as much as the best one?
    [[nodiscard]] bool is_close(const Prediction& one, const Prediction& best) const {
        const double here = visited_[base_].log_evidence;
        return one.log_evidence - here > close_share * (best.log_evidence - here) ||
               one.log_evidence > best.log_evidence - policy_.unvisited_margin;
    }

    /// The models that the linear estimate leads to; none if it was made about another model.
    [[nodiscard]] std::optional<fit::StartModels> start_of(const Prediction& prediction) const {
        if (prediction.base != base_ || !linear_)
            return std::nullopt;
        return start_at_estimate(base_fit_, baseline_.recordings, views_, *linear_,
                                 prediction.candidates, prediction.gain);
    }

    // --- Fits

    [[nodiscard]] const fit::Fit& largest_within(const fit::SelectedEffects& effects) const {
        const bool is_within = std::ranges::all_of(
            base_fit_.effects, [&](const auto& each) { return fit::contains(effects, each); });
        return is_within ? base_fit_ : baseline_.fit;
    }

    void visit(const std::vector<PlannedModel>& planned) {
        std::vector<std::string> names;
        std::vector<double> costs;
        for (const PlannedModel& model : planned) {
            names.push_back(fmt::format(
                "{}", fmt::join(fit::model_names(fit::in_library_order(model.effects)), " + ")));
            costs.push_back(fit::relative_cost(model.effects));
        }
        report(fmt::format("fitting {}", fmt::join(names, "; ")));
        std::vector<std::optional<FittedModel>> answers =
            options_.map.values(costs, [&](std::size_t item, const run::Heartbeat& heartbeat) {
                return fit_planned(planned[item], largest_within(planned[item].effects),
                                   baseline_.recordings, options_.known,
                                   with_heartbeat(options_.candidate, heartbeat));
            });
        for (std::size_t k = 0; k < planned.size(); ++k) {
            FittedModel model;
            if (answers[k])
                model = *std::move(answers[k]);
            model.fit = fit::arrived(answers[k] ? std::optional(model.fit) : std::nullopt,
                                     planned[k].effects);
            runs_ += model.fit.runs;
            add_visited(std::move(model), planned[k].predicted);
        }
    }

    // --- Noise about the best model

    /// The likeliest models fitted again with the noise about the best one; false if that is the
    /// same.
    [[nodiscard]] bool estimate_noise_again() {
        if (base_fit_.effects.empty() || noise_estimates_ == most_noise_estimates ||
            key_of(base_fit_.effects) == noise_about_)
            return false;
        noise_about_ = key_of(base_fit_.effects);
        ++noise_estimates_;
        stated_best_ =
            fit::as_stated(base_fit_, baseline_.stated, baseline_.recordings, options_.candidate);
        std::optional<fit::BaselineFit> again =
            fit::baseline_beside_noise_of(*stated_best_, baseline_, measured_, options_.candidate);
        if (!again || again->fit.failed())
            return false;
        report("fitting the likeliest models with the noise about the best one");
        std::vector<VisitedModel> likely;
        for (std::size_t k = 1; k < visited_.size(); ++k)
            if (k == base_ || visited_[k].log_evidence > least_wanted() - hopeless)
                likely.push_back(visited_[k]);
        const double before = visited_.front().log_evidence;
        const double chi_squared = baseline_.fit.chi_squared;
        baseline_ = *std::move(again);
        repeated_.clear();
        inherited_.clear();
        visit_first();
        // What was predicted about the chain falls in χ² as the chain itself does, nearly.
        const double ratio = baseline_.fit.chi_squared / chi_squared;
        std::erase_if(predictions_, [](const auto& entry) { return entry.second.base != 0; });
        for (auto& [key, prediction] : predictions_)
            prediction.log_evidence =
                visited_.front().log_evidence + ratio * (prediction.log_evidence - before);
        std::vector<PlannedModel> planned;
        for (const VisitedModel& model : likely)
            if (!model.fit.failed())
                planned.push_back(
                    {model.fit.effects, not_predicted,
                     fit::models_of(model.fit, baseline_.recordings, options_.candidate)});
        visit(planned);
        return true;
    }

    [[nodiscard]] static UnvisitedModel unvisited(Prediction prediction) {
        UnvisitedModel model;
        const std::size_t before = prediction.effects.size() - prediction.candidates.size();
        for (std::size_t k = before; k < prediction.effects.size(); ++k)
            model.added.push_back(prediction.effects[k].effect->name());
        model.effects = std::move(prediction.effects);
        model.log_evidence = prediction.log_evidence;
        model.base = prediction.base;
        model.falls = std::move(prediction.gain.falls);
        return model;
    }

    [[nodiscard]] SearchResult result() {
        SearchResult out;
        predict();
        for (auto& [key, prediction] : predictions_)
            if (std::isfinite(prediction.log_evidence) && !is_visited(prediction.effects))
                out.unvisited.push_back(unvisited(std::move(prediction)));
        std::ranges::stable_sort(out.unvisited, std::greater{}, &UnvisitedModel::log_evidence);
        if (!stated_best_)
            stated_best_ = fit::as_stated(base_fit_, baseline_.stated, baseline_.recordings,
                                          options_.candidate);
        out.recordings = std::move(baseline_.recordings);
        out.baseline = std::move(baseline_.fit);
        out.stated_baseline = std::move(baseline_.stated);
        out.best = base_;
        out.visited = std::move(visited_);
        out.noise = noise_scale_of(out.visited[base_].fit);
        out.best_fit = std::move(base_fit_);
        out.stated_best = *std::move(stated_best_);
        out.views = std::move(views_);
        out.stacked = std::move(stacked_);
        out.runs = runs_;
        return out;
    }

    std::span<const measure::Measurement> measured_;
    const SearchOptions& options_;
    const Policy& policy_;
    fit::BaselineFit baseline_;
    std::vector<VisitedModel> visited_;
    std::map<ModelKey, Prediction> predictions_;
    std::set<ModelKey> repeated_;  ///< from all starts
    std::set<ModelKey> inherited_; ///< from a larger model
    NoiseScale noise_;
    std::size_t base_ = 0; ///< the model about which everything is predicted
    fit::Fit base_fit_;
    StackedReadings stacked_;
    std::vector<CandidateView> views_;
    std::optional<LinearEvidence> linear_; ///< of `views_`; empty: not computed about this model
    std::optional<fit::Fit> stated_best_;
    ModelKey noise_about_; ///< the model about which the noise was estimated last
    int noise_estimates_ = 0;
    int runs_ = 0;
};

} // namespace

SearchResult search_models(std::span<const measure::Measurement> recordings,
                           const SearchOptions& options, const Policy& policy) {
    return Search(recordings, options, policy).run();
}

} // namespace culm::diagnose
