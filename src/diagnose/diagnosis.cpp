// SPDX-License-Identifier: BSD-3-Clause
#include "diagnose/diagnosis.hpp"

#include "core/error.hpp"
#include "diagnose/candidate_field.hpp"
#include "diagnose/diagnosis_answer.hpp"
#include "diagnose/mere_noise.hpp"
#include "diagnose/naming.hpp"

#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include <fmt/core.h>
#include <fmt/ranges.h>

namespace culm::diagnose {
namespace {

constexpr double promising_gain = 8.0; ///< of χ², for which a fit is worth its runs
/// Of what an effect gains, that another has to promise to be tried in its place.
constexpr double promised_share = 0.3;
constexpr std::size_t pairs_of = 3; ///< best single effects that are tried in pairs
constexpr int most_exchanges = 3;

class Search {
  public:
    Search(std::span<const measure::Measurement> recordings, const DiagnosisOptions& options)
        : recordings_(recordings), options_(options), field_(recordings, options) {}

    [[nodiscard]] Diagnosis run() {
        for (const measure::Measurement& recording : recordings_)
            refuse_mere_noise(recording, options_.candidate.window);
        tell("fitting the published chain");
        fit_ = field_.fit({}, {});
        result_.baseline = fit_;
        if (!options_.known.empty())
            fit_ = field_.fit(options_.known, fit_);
        current_ = fit::numbers_of(fit_);
        add_rung({});
        while (goes_on()) {
        }
        if (added() > 0)
            exchange();
        unite_imitators();
        conclude();
        return std::move(result_);
    }

  private:
    void tell(const std::string& what) const {
        if (options_.progress)
            options_.progress(what);
    }
    [[nodiscard]] std::size_t added() const {
        return current_.effects.size() - options_.known.size();
    }

    void add_rung(const HeldOutGain& held_out) {
        const SetVerdict verdict = judge(fit_, recordings_);
        DiagnosisRung rung;
        rung.fit = current_;
        rung.finding = verdict.finding;
        rung.p_value = verdict.p_value;
        rung.tests = verdict.reason;
        rung.held_out = held_out.larger;
        rung.held_out_before = held_out.smaller;
        result_.ladder.push_back(std::move(rung));
    }
    [[nodiscard]] Finding finding() const { return result_.ladder.back().finding; }

    /// Worth every effort, and an "unknown" if that is in vain.
    [[nodiscard]] bool fails_clearly() const {
        return finding() == Finding::Inadequate &&
               result_.ladder.back().p_value < clear_failure_level;
    }

    /// One step forward; false where the search ends.
    [[nodiscard]] bool goes_on() {
        if (finding() == Finding::Undecided)
            return false;
        if (!fit_.moves()) { // what does not move has no derivatives
            scores_.clear();
            return added() < options_.most_effects && step();
        }
        tell(fmt::format("scoring the candidates beside {}", fmt::join(current_.names, " + ")));
        const bool is_full = added() >= options_.most_effects;
        // Where a step will hardly fail there is no need yet of what could not be seen.
        are_scores_final_ = is_full || !fails_clearly();
        scores_ = field_.score(fit_, current_.effects, are_scores_final_ ? options_.null_draws : 0);
        if (is_full || (finding() == Finding::Adequate &&
                        (added() > 0 || !promises_significant_gain(scores_, current_))))
            return false;
        return step();
    }

    [[nodiscard]] bool step() {
        std::vector<fit::Fit> models = fitted(true, {});
        bool has_named = name_best(models);
        if (!has_named && fails_clearly()) {
            const std::vector<fit::Fit> others = fitted(false, models);
            models.insert(models.end(), others.begin(), others.end());
            has_named = name_best(models);
        }
        if (!has_named && fails_clearly() && added() + 2 <= options_.most_effects) {
            const std::vector<fit::SelectedEffects> pairs = pairs_of_best(models, pairs_of);
            tell(fmt::format("fitting {} pairs of effects", pairs.size()));
            std::vector<fit::Fit> fitted_pairs =
                field_.fit_all(pairs, fit_, step_limit(current_, 2));
            has_named = name_best(fitted_pairs);
        }
        if (first_step_.empty()) {
            first_step_ = models;
            first_scores_ = scores_;
            first_smaller_ = result_.ladder.front().fit;
        }
        return has_named;
    }

    /// The candidates that promise most, or something, as far as they are not among `done`.
    [[nodiscard]] std::vector<fit::Fit> fitted(bool only_best, const std::vector<fit::Fit>& done) {
        std::vector<fit::SelectedEffects> models =
            field_.one_more(current_.effects, scores_, promising_gain, only_best);
        std::erase_if(models, [&](const fit::SelectedEffects& effects) {
            return std::ranges::any_of(done, [&](const fit::Fit& model) {
                return model.effects.back().effect == effects.back().effect;
            });
        });
        tell(fmt::format("fitting {} candidates beside {}", models.size(),
                         fmt::join(current_.names, " + ")));
        const double needed = fit_.chi_squared - step_limit(current_, 1);
        return field_.fit_promising(models, scores_, fit_, std::max(needed, 0.0));
    }

    [[nodiscard]] Yardstick yardstick_with(const std::vector<fit::Fit>& models) const {
        std::vector<fit::Fit> fits{current_};
        for (const fit::Fit& model : models)
            fits.push_back(model);
        return yardstick(fits);
    }

    /// Why this larger model is no step; empty if it is.
    [[nodiscard]] std::string obstacle(const fit::Fit& model, const Yardstick& by) const {
        for (std::size_t k = current_.effects.size(); k < model.effects.size(); ++k)
            if (std::string text = naming_obstacle(model, model.effects[k].effect->name());
                !text.empty())
                return text;
        return step_obstacle(current_, model, by, scores_.size());
    }

    /// Takes the best of the models that are a step; false if none is. Only if the best gain enough
    /// but are refused, it matters where the others end.
    [[nodiscard]] bool name_best(std::vector<fit::Fit>& models) {
        if (name_best_of(models))
            return true;
        const Yardstick by = yardstick_with(models);
        const auto is_refused_gain = [&](const fit::Fit& model) {
            return model.is_fitted() && !model.out_of_reach &&
                   step_obstacle(current_, model, by, scores_.size()).empty();
        };
        if (std::ranges::none_of(
                models, [](const auto& model) { return model.out_of_reach.has_value(); }) ||
            std::ranges::none_of(models, is_refused_gain))
            return false;
        tell("following the others to their end");
        const std::size_t more = models.front().effects.size() - current_.effects.size();
        models = field_.followed(std::move(models), fit_, step_limit(current_, more));
        return name_best_of(models);
    }

    /// The same of those that were followed to their end, up to the first that was not.
    [[nodiscard]] bool name_best_of(std::vector<fit::Fit> models) {
        const Yardstick by = yardstick_with(models);
        std::erase_if(models, [&](const fit::Fit& model) {
            return refused_models_.contains(model.names) || !obstacle(model, by).empty();
        });
        std::ranges::stable_sort(models, {}, [&](const fit::Fit& model) { return bic(model, by); });
        // What acts for certain, with nothing to fit, goes before what would have to be assumed.
        std::ranges::stable_partition(
            models, [&](const fit::Fit& model) { return acts_for_certain(current_, model); });
        for (const fit::Fit& model : models) {
            if (model.out_of_reach)
                return false;
            fit::Fit larger = field_.restore(model);
            tell(fmt::format("predicting what {} has not seen", fmt::join(model.names, " + ")));
            const HeldOutGain held_out =
                held_out_gain(fit_, larger, recordings_, options_.candidate, options_.map);
            if (!held_out.obstacle.empty()) {
                refused_models_.insert(model.names);
                refused_[model.effects.back().effect->name()] = held_out.obstacle;
                continue;
            }
            fit::Fit found = where_it_is_needed(model);
            if (found.parameters.size() < model.parameters.size())
                larger = field_.restore(found);
            const double gain = bic(current_, by) - bic(found, by);
            take(found, std::move(larger), held_out);
            result_.ladder.back().delta_bic = -gain;
            return true;
        }
        return false;
    }

    /// What belongs to a recording (a mass at its tip) need not be in all of them: it leaves those
    /// that do as well without it.
    [[nodiscard]] fit::Fit where_it_is_needed(fit::Fit model) {
        while (true) {
            std::vector<fit::Fit> fewer = field_.fit_all(
                field_.in_fewer_recordings(model.effects, current_.effects.size()), fit_);
            std::erase_if(fewer, [](const fit::Fit& each) { return !each.is_fitted(); });
            if (fewer.empty())
                return model;
            const Yardstick by = yardstick_with({model});
            const auto best = std::ranges::min_element(
                fewer, {}, [&](const fit::Fit& each) { return bic(each, by); });
            if (!(bic(*best, by) - bic(model, by) < tie_gap))
                return model;
            model = *best;
        }
    }

    void take(const fit::Fit& model, fit::Fit fit, const HeldOutGain& held_out) {
        are_scores_final_ = false;
        current_ = model;
        fit_ = std::move(fit);
        add_rung(held_out);
    }

    /// Exchanges every effect of the answer for every other candidate; what acts for certain stays.
    void exchange() {
        for (int pass = 0; pass < most_exchanges; ++pass) {
            rivals_.clear();
            bool has_changed = false;
            for (std::size_t k = options_.known.size(); k < current_.effects.size(); ++k)
                if (fit::has_fitted_number(*current_.effects[k].effect) && exchange_one(k)) {
                    has_changed = true;
                    break;
                }
            if (!has_changed)
                return;
        }
    }

    /// The fit without one of the effects, and the models with another in its place.
    struct Without {
        fit::Fit smaller;
        std::vector<fit::Fit> models;
    };

    [[nodiscard]] Without rivals_of(std::size_t place) {
        fit::SelectedEffects rest = current_.effects;
        rest.erase(rest.begin() + static_cast<std::ptrdiff_t>(place));
        if (rest.size() == options_.known.size())
            return {first_smaller_, first_step_};
        tell(fmt::format("what else could stand for {}", current_.effects[place].effect->name()));
        const fit::Fit smaller = field_.recall(rest, result_.baseline);
        Without out{fit::numbers_of(smaller), {}};
        if (smaller.failed())
            return out;
        const std::vector<EffectScore> scores = field_.score(smaller, rest, 0);
        const double needed = smaller.chi_squared - current_.chi_squared;
        std::vector<fit::SelectedEffects> others =
            field_.one_more(rest, scores, std::max(promising_gain, promised_share * needed), true);
        std::erase_if(others, [&](const fit::SelectedEffects& model) {
            return model.back().effect == current_.effects[place].effect;
        });
        out.models = field_.fit_promising(others, scores, smaller, needed);
        return out;
    }

    /// True if a better or smaller set has taken the place of the current one.
    [[nodiscard]] bool exchange_one(std::size_t place) {
        const std::string out = current_.effects[place].effect->name();
        Without without = rivals_of(place);
        std::erase_if(without.models, [&](const fit::Fit& model) {
            return model.effects.back().effect->name() == out;
        });
        const Yardstick by = yardstick_with(without.models);
        const double here = bic(current_, by);
        if (added() > 1 && without.smaller.is_fitted() &&
            bic(without.smaller, by) - here < tie_gap) {
            return replace(without.smaller, by);
        }
        std::erase_if(without.models, [](const fit::Fit& model) {
            return !is_rival(model, model.effects.back().effect->name());
        });
        std::ranges::stable_sort(without.models, {},
                                 [&](const fit::Fit& model) { return bic(model, by); });
        Rivals group{current_.effects[place], {}, {}};
        // Where structure is left, what decides between two is what neither explains.
        const bool is_open = finding() == Finding::Inadequate;
        for (const fit::Fit& model : without.models) {
            const double gap = bic(model, by) - here;
            if (gap < -tie_gap &&
                naming_obstacle(model, model.effects.back().effect->name()).empty())
                return replace(model, by);
            if (gap < tie_gap || (gap < clear_gap && leaves_noise(model)) ||
                (is_open && explains(result_.ladder.front().fit, model, nearly_all))) {
                group.models.push_back(model);
                group.delta_bic.push_back(gap);
            }
        }
        if (!group.models.empty())
            rivals_.push_back(std::move(group));
        return false;
    }

    [[nodiscard]] bool leaves_noise(const fit::Fit& model) {
        const fit::Fit fit = field_.restore(model);
        return !fit.failed() && judge(fit, recordings_).finding == Finding::Adequate;
    }

    [[nodiscard]] bool replace(const fit::Fit& model, const Yardstick& by) {
        const double gain = bic(current_, by) - bic(model, by);
        take(model, field_.restore(model), {});
        result_.ladder.back().delta_bic = -gain;
        return true;
    }

    /// Two effects, each of which alone explains all but a trace, do together what one law between
    /// them would: one of them is missing, and not both.
    void unite_imitators() {
        if (added() != 2 || !current_.is_noise_known_anywhere())
            return;
        const std::size_t known = options_.known.size();
        const fit::Fit* better =
            single_of(first_step_, current_.effects[known].effect->name(), known);
        const fit::Fit* other =
            single_of(first_step_, current_.effects.back().effect->name(), known);
        if (better == nullptr || other == nullptr ||
            !explains(first_smaller_, *better, all_but_a_trace) ||
            !explains(first_smaller_, *other, all_but_a_trace))
            return;
        const Yardstick by = yardstick_with({*better, *other});
        if (bic(*other, by) < bic(*better, by))
            std::swap(better, other);
        rivals_ = {{better->effects.back(), {*other}, {bic(*other, by) - bic(*better, by)}}};
        is_one_law_ = true;
        result_.ladder.resize(1);
        take(*better, field_.restore(*better), {});
        result_.ladder.back().delta_bic = bic(*better, by) - bic(first_smaller_, by);
    }

    void conclude() {
        if (!are_scores_final_ && finding() != Finding::Undecided) {
            tell("what the recording cannot show");
            scores_ = field_.score(fit_, current_.effects, options_.null_draws);
        }
        result_.runs = field_.runs();
        result_.final_fit = fit_;
        result_.blind_spots = scores_;
        complete({recordings_, options_, field_.candidates(), current_, result_.ladder.front().fit,
                  first_step_, first_scores_.empty() ? scores_ : first_scores_, rivals_, refused_,
                  is_one_law_},
                 result_);
        if (!result_.effects.empty() && finding() == Finding::Inadequate) {
            tell("weighing what the model misses");
            result_.correlated = correlated_estimate(fit_, recordings_, options_.candidate);
        }
    }

    std::span<const measure::Measurement> recordings_;
    const DiagnosisOptions& options_;
    CandidateField field_;
    fit::Fit current_;
    fit::Fit fit_;                    ///< of the current model
    bool is_one_law_ = false;         ///< as Found's
    std::vector<EffectScore> scores_; ///< of the candidates beside the current model
    bool are_scores_final_ = false;   ///< are they?
    std::vector<fit::Fit> first_step_;
    std::vector<EffectScore> first_scores_;
    fit::Fit first_smaller_;
    std::vector<Rivals> rivals_;
    std::map<std::string, std::string> refused_;        ///< effects that predict no better, and why
    std::set<std::vector<std::string>> refused_models_; ///< likewise
    Diagnosis result_;
};

} // namespace

Diagnosis diagnose(std::span<const measure::Measurement> recordings,
                   const DiagnosisOptions& options) {
    return Search(recordings, options).run();
}

} // namespace culm::diagnose
