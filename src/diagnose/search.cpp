// SPDX-License-Identifier: BSD-3-Clause
#include "core/error.hpp"
#include "diagnose/answer.hpp"
#include "diagnose/candidate_field.hpp"
#include "diagnose/criterion.hpp"
#include "diagnose/diagnosis.hpp"
#include "diagnose/judge.hpp"

#include <algorithm>
#include <memory>
#include <optional>
#include <set>
#include <utility>

#include <fmt/core.h>
#include <fmt/ranges.h>

namespace culm::diagnose {
namespace {

/// Before anything is named: does a candidate promise more than noise would, for as many as there
/// are? The tests for lack of fit look at everything and so miss the weak signature of one effect.
bool promises_significant_gain(const std::vector<EffectScore>& scores, const fit::Fit& model,
                               const Policy& policy) {
    const Criterion own = criterion(model, {});
    return std::ranges::any_of(scores, [&](const EffectScore& score) {
        const double gain = score.gain / own.inflation * own.share;
        return score.failure.empty() &&
               gain_p_value(gain, score.added) * static_cast<double>(scores.size()) <
                   policy.naming_level;
    });
}

/// Where the search stands. A step makes a new state; a state does not change.
struct State {
    fit::Fit model; ///< its numbers, with the effects in the order in which they were found
    std::shared_ptr<const fit::Fit> fit; ///< the same with residuals and derivatives
    std::vector<SearchedModel> ladder;   ///< the models on the way here; the last is this one
    std::vector<EffectScore> scores;     ///< of the candidates beside this model
    bool are_scores_final = false;       ///< do the scores say what could not be seen?
    FirstStep first;
    std::vector<Rivals> rivals;
    bool is_one_law = false; ///< as Found's
    /// Models that predict no better, and what is said of the effects that they add.
    std::set<std::vector<std::string>> refused_models;
    std::map<std::string, std::string> refused;

    [[nodiscard]] Finding finding() const { return ladder.back().finding; }
};

/// A new state, and whether it has a new model.
struct Advance {
    State state;
    bool has_new_model = false;
};

/// The steps of the search. Each takes a state and gives another; the only memory beside the states
/// is the field's, of fits and scores that were computed before.
class Search {
  public:
    Search(const fit::BaselineFit& baseline, const DiagnosisOptions& options)
        : recordings_(baseline.recordings), options_(options), policy_(options.policy),
          field_(baseline.recordings, options), baseline_(baseline.fit),
          stated_baseline_(baseline.stated) {}

    [[nodiscard]] int runs() const { return field_.runs(); }

    [[nodiscard]] State find() {
        State state = begin();
        for (bool goes_on = true; goes_on;) {
            Advance next = advance(std::move(state));
            state = std::move(next.state);
            goes_on = next.has_new_model;
        }
        if (added(state) > 0)
            state = exchanged(std::move(state));
        return with_imitators_united(std::move(state));
    }

    [[nodiscard]] Diagnosis answer(State state) {
        if (!state.are_scores_final && state.finding() != Finding::Undecided) {
            report("computing detection limits");
            state.scores = field_.score(*state.fit, state.model.effects, options_.null_draws);
        }
        if (state.first.scores.empty())
            state.first.scores = state.scores;
        Diagnosis result;
        result.baseline = baseline_;
        result.stated_baseline = stated_baseline_;
        result.policy = policy_;
        result.ladder = std::move(state.ladder);
        for (SearchedModel& model : result.ladder)
            if (model.stated.parts.empty())
                model.stated =
                    fit::as_stated(model.fit, stated_baseline_, recordings_, options_.candidate);
        result.runs = field_.runs();
        result.final_fit = *state.fit;
        result.blind_spots = state.scores;
        complete({recordings_, options_, field_.candidates(), state.model,
                  result.ladder.front().fit, state.first, state.rivals, state.refused,
                  state.is_one_law},
                 result);
        return result;
    }

  private:
    void report(const std::string& what) const {
        if (options_.progress)
            options_.progress(what);
    }
    [[nodiscard]] std::size_t added(const State& state) const {
        return state.model.effects.size() - options_.known.size();
    }
    /// Worth every effort, and an "unknown" if that is in vain.
    [[nodiscard]] bool fails_clearly(const State& state) const {
        return state.finding() == Finding::Inadequate &&
               state.ladder.back().p_value < policy_.clear_failure_level;
    }

    [[nodiscard]] State begin() {
        fit::Fit fit = field_.keep({}, baseline_);
        if (!options_.known.empty())
            fit = field_.fit(options_.known, fit);
        const fit::Fit numbers = fit::numbers_of(fit);
        return with_model({}, numbers, std::move(fit), {}, 0.0);
    }

    /// The state with another model, and one more in its ladder.
    [[nodiscard]] State with_model(State state, const fit::Fit& model, fit::Fit fit,
                                   const HeldOutPair& held_out, double gain) const {
        const SetVerdict verdict = verdict_on(fit, recordings_, policy_);
        SearchedModel entry;
        entry.fit = model;
        entry.finding = verdict.finding;
        entry.p_value = verdict.p_value;
        entry.tests = verdict.reason;
        entry.delta_bic = 0.0 - gain;
        entry.held_out = held_out.larger.last_third.over_noise;
        entry.held_out_before = held_out.smaller.last_third.over_noise;
        state.ladder.push_back(std::move(entry));
        state.model = model;
        state.fit = std::make_shared<const fit::Fit>(std::move(fit));
        state.are_scores_final = false;
        return state;
    }

    [[nodiscard]] Advance advance(State state) {
        if (state.finding() == Finding::Undecided)
            return {std::move(state)};
        const bool is_full = added(state) >= options_.most_effects;
        if (!state.fit->moves()) { // what does not move has no derivatives
            state.scores.clear();
            return is_full ? Advance{std::move(state)} : step(state);
        }
        report(
            fmt::format("scoring the candidates beside {}", fmt::join(state.model.names, " + ")));
        // Where a step will hardly fail there is no need yet of what could not be seen.
        state.are_scores_final = is_full || !fails_clearly(state);
        state.scores = field_.score(*state.fit, state.model.effects,
                                    state.are_scores_final ? options_.null_draws : 0);
        const bool is_done =
            state.finding() == Finding::Adequate &&
            (added(state) > 0 || !promises_significant_gain(state.scores, state.model, policy_));
        return is_full || is_done ? Advance{std::move(state)} : step(state);
    }

    /// Tries the promising candidates, then all others, then pairs of the best.
    [[nodiscard]] Advance step(const State& state) {
        std::vector<fit::Fit> models = fitted(state, true, {});
        const bool has_first = !state.first.models.empty();
        Advance next = with_best_of(state, models);
        if (!next.has_new_model && fails_clearly(state)) {
            const std::vector<fit::Fit> others = fitted(state, false, models);
            models.insert(models.end(), others.begin(), others.end());
            next = with_best_of(next.state, models);
        }
        if (!next.has_new_model && fails_clearly(state) &&
            added(state) + 2 <= options_.most_effects) {
            const std::vector<fit::SelectedEffects> pairs =
                pairs_of_best(models, policy_.pairs_of_best);
            report(fmt::format("fitting {} pairs of effects", pairs.size()));
            std::vector<fit::Fit> fitted_pairs =
                field_.fit_all(pairs, *state.fit, step_limit(state.model, 2, policy_));
            next = with_best_of(next.state, fitted_pairs);
        }
        if (!has_first)
            next.state.first = {std::move(models), state.scores};
        return next;
    }

    /// The candidates that promise most, or something, as far as they are not among `done`.
    [[nodiscard]] std::vector<fit::Fit> fitted(const State& state, bool only_best,
                                               const std::vector<fit::Fit>& done) {
        std::vector<fit::SelectedEffects> models =
            field_.one_more(state.model.effects, state.scores, policy_.promising_gain, only_best);
        std::erase_if(models, [&](const fit::SelectedEffects& effects) {
            return std::ranges::any_of(done, [&](const fit::Fit& model) {
                return model.effects.back().effect == effects.back().effect;
            });
        });
        report(fmt::format("fitting {} candidates beside {}", models.size(),
                           fmt::join(state.model.names, " + ")));
        const double needed = state.fit->chi_squared - step_limit(state.model, 1, policy_);
        return field_.fit_promising(models, state.scores, *state.fit, std::max(needed, 0.0));
    }

    [[nodiscard]] Judgement judge_model(const State& state, const fit::Fit& model,
                                        const Criterion& by) const {
        return judge({.smaller = state.model,
                      .larger = model,
                      .criterion = by,
                      .added = names_behind(model, state.model.effects.size()),
                      .tried = state.scores.size()},
                     policy_);
    }

    /// With the best of the models that are accepted. Only if the best gain enough but are refused,
    /// it matters where the others end.
    [[nodiscard]] Advance with_best_of(const State& state, std::vector<fit::Fit>& models) {
        Advance next = with_best_of_followed(state, models);
        if (next.has_new_model)
            return next;
        const Criterion by = criterion(state.model, models);
        const auto is_refused_gain = [&](const fit::Fit& model) {
            return model.is_fitted() && !model.out_of_reach &&
                   judge_model(state, model, by).gains_enough();
        };
        if (std::ranges::none_of(
                models, [](const auto& model) { return model.out_of_reach.has_value(); }) ||
            std::ranges::none_of(models, is_refused_gain))
            return next;
        report("following the others to their end");
        const std::size_t more = models.front().effects.size() - state.model.effects.size();
        models =
            field_.followed(std::move(models), *state.fit, step_limit(state.model, more, policy_));
        return with_best_of_followed(next.state, models);
    }

    /// The same of those that were followed to their end, up to the first that was not.
    [[nodiscard]] Advance with_best_of_followed(State state, std::vector<fit::Fit> models) {
        const Criterion by = criterion(state.model, models);
        std::erase_if(models, [&](const fit::Fit& model) {
            return state.refused_models.contains(model.names) ||
                   !judge_model(state, model, by).is_accepted();
        });
        std::ranges::stable_sort(models, {}, [&](const fit::Fit& model) { return bic(model, by); });
        // What acts for certain, with nothing to fit, goes before what would have to be assumed.
        std::ranges::stable_partition(models, [&](const fit::Fit& model) {
            return acts_for_certain(state.model, model, policy_);
        });
        for (const fit::Fit& model : models) {
            if (model.out_of_reach)
                break;
            fit::Fit larger = field_.restore(model);
            report(fmt::format("predicting the readings held out from {}",
                               fmt::join(model.names, " + ")));
            const HeldOutPair held_out = hold_out_from_both(*state.fit, larger, recordings_,
                                                            options_.candidate, options_.map);
            Step step{state.model, model, by, names_behind(model, state.model.effects.size()),
                      state.scores.size()};
            step.held_out = held_out;
            if (const Judgement judgement = judge(step, policy_); !judgement.is_accepted()) {
                state.refused_models.insert(model.names);
                state.refused[model.effects.back().effect->name()] = in_words(judgement, policy_);
                continue;
            }
            const fit::Fit found = where_it_is_needed(state, model);
            if (found.parameters.size() < model.parameters.size())
                larger = field_.restore(found);
            const double gain = bic(state.model, by) - bic(found, by);
            return {with_model(std::move(state), found, std::move(larger), held_out, gain), true};
        }
        return {std::move(state)};
    }

    /// What belongs to a recording (a mass at its tip) need not be in all of them: it leaves those
    /// that do as well without it.
    [[nodiscard]] fit::Fit where_it_is_needed(const State& state, fit::Fit model) {
        while (true) {
            const std::vector<fit::SelectedEffects> smaller =
                field_.in_fewer_recordings(model.effects, state.model.effects.size());
            std::vector<fit::Fit> fewer = field_.fit_all(smaller, *state.fit);
            std::erase_if(fewer, [](const fit::Fit& each) { return !each.is_fitted(); });
            if (fewer.empty())
                return model;
            const Criterion by = criterion(state.model, std::vector{model});
            const auto best = std::ranges::min_element(
                fewer, {}, [&](const fit::Fit& each) { return bic(each, by); });
            if (!(bic(*best, by) - bic(model, by) < policy_.tie_gap))
                return model;
            model = *best;
        }
    }

    /// Exchanges every effect of the answer for every other candidate; what acts for certain stays.
    [[nodiscard]] State exchanged(State state) {
        for (int pass = 0; pass < policy_.most_exchanges; ++pass) {
            state.rivals.clear();
            bool has_changed = false;
            for (std::size_t k = options_.known.size();
                 k < state.model.effects.size() && !has_changed; ++k) {
                if (!fit::has_fitted_number(*state.model.effects[k].effect))
                    continue;
                Advance next = with_exchange(state, k);
                state = std::move(next.state);
                has_changed = next.has_new_model;
            }
            if (!has_changed)
                break;
        }
        return state;
    }

    /// The fit without one of the effects, and the models with another in its place.
    struct Without {
        fit::Fit smaller;
        std::vector<fit::Fit> models;
    };

    [[nodiscard]] Without rivals_of(const State& state, std::size_t place) {
        fit::SelectedEffects rest = state.model.effects;
        rest.erase(rest.begin() + static_cast<std::ptrdiff_t>(place));
        if (rest.size() == options_.known.size())
            return {state.ladder.front().fit, state.first.models};
        report(fmt::format("fitting other effects in place of {}",
                           state.model.effects[place].effect->name()));
        const fit::Fit smaller = field_.recall(rest, baseline_);
        Without out{fit::numbers_of(smaller), {}};
        if (smaller.failed())
            return out;
        const std::vector<EffectScore> scores = field_.score(smaller, rest, 0);
        const double needed = smaller.chi_squared - state.model.chi_squared;
        std::vector<fit::SelectedEffects> others = field_.one_more(
            rest, scores, std::max(policy_.promising_gain, policy_.promised_share * needed), true);
        std::erase_if(others, [&](const fit::SelectedEffects& model) {
            return model.back().effect == state.model.effects[place].effect;
        });
        out.models = field_.fit_promising(others, scores, smaller, needed);
        return out;
    }

    /// With a better or smaller set in place of the current one, or with the rivals of one effect.
    [[nodiscard]] Advance with_exchange(State state, std::size_t place) {
        const std::string out = state.model.effects[place].effect->name();
        Without without = rivals_of(state, place);
        std::erase_if(without.models, [&](const fit::Fit& model) {
            return model.effects.back().effect->name() == out;
        });
        const Criterion by = criterion(state.model, without.models);
        const double here = bic(state.model, by);
        if (added(state) > 1 && without.smaller.is_fitted() &&
            bic(without.smaller, by) - here < policy_.tie_gap)
            return replaced(std::move(state), without.smaller, by);
        std::erase_if(without.models, [](const fit::Fit& model) {
            return !is_rival(model, model.effects.back().effect->name());
        });
        std::ranges::stable_sort(without.models, {},
                                 [&](const fit::Fit& model) { return bic(model, by); });
        Rivals group{state.model.effects[place], {}, {}};
        for (const fit::Fit& model : without.models) {
            const double gap = bic(model, by) - here;
            if (gap < -policy_.tie_gap &&
                judge_effect(model, model.effects.back().effect->name()).is_accepted())
                return replaced(std::move(state), model, by);
            if (is_tie(state, model, gap)) {
                group.models.push_back(model);
                group.delta_bic.push_back(gap);
            }
        }
        if (!group.models.empty())
            state.rivals.push_back(std::move(group));
        return {std::move(state)};
    }

    [[nodiscard]] bool is_tie(const State& state, const fit::Fit& model, double gap) {
        if (gap < policy_.tie_gap || (gap < policy_.clear_gap && leaves_noise(model)))
            return true;
        // Where structure is left, what decides between two is what neither explains.
        return state.finding() == Finding::Inadequate &&
               explains(state.ladder.front().fit, model, policy_.share_beside_structure);
    }

    [[nodiscard]] bool leaves_noise(const fit::Fit& model) {
        const fit::Fit fit = field_.restore(model);
        return !fit.failed() && verdict_on(fit, recordings_, policy_).finding == Finding::Adequate;
    }

    [[nodiscard]] Advance replaced(State state, const fit::Fit& model, const Criterion& by) {
        const double gain = bic(state.model, by) - bic(model, by);
        return {with_model(std::move(state), model, field_.restore(model), {}, gain), true};
    }

    /// Two effects, each of which alone explains nearly all of the misfit, do together what one law
    /// between them would: one of them is missing, and not both.
    [[nodiscard]] State with_imitators_united(State state) {
        if (added(state) != 2 || !state.model.is_noise_known_anywhere())
            return state;
        const std::size_t known = options_.known.size();
        const std::vector<fit::Fit>& singles = state.first.models;
        const fit::Fit* better =
            single_of(singles, state.model.effects[known].effect->name(), known);
        const fit::Fit* other =
            single_of(singles, state.model.effects.back().effect->name(), known);
        if (better == nullptr || other == nullptr ||
            !explains(state.ladder.front().fit, *better, policy_.share_of_one_law) ||
            !explains(state.ladder.front().fit, *other, policy_.share_of_one_law))
            return state;
        const Criterion by = criterion(state.model, std::vector{*better, *other});
        if (bic(*other, by) < bic(*better, by))
            std::swap(better, other);
        State united = state;
        united.rivals = {{better->effects.back(), {*other}, {bic(*other, by) - bic(*better, by)}}};
        united.is_one_law = true;
        united.ladder.resize(1);
        const double gain = bic(state.ladder.front().fit, by) - bic(*better, by);
        return with_model(std::move(united), *better, field_.restore(*better), {}, gain);
    }

    std::span<const fit::ObservedRecording> recordings_;
    const DiagnosisOptions& options_;
    const Policy& policy_;
    CandidateField field_;
    const fit::Fit& baseline_;
    const fit::Fit& stated_baseline_;
};

} // namespace

Diagnosis diagnose(std::span<const measure::Measurement> recordings, DiagnosisOptions options) {
    if (options.candidates.empty())
        options.candidates = fit::candidate_effects(recordings);
    for (const measure::Measurement& recording : recordings)
        refuse_without_motion(recording, options.candidate.window, options.policy);
    if (options.progress)
        options.progress("fitting the published chain");
    const fit::BaselineFit baseline = fit::fit_baseline(recordings, options.candidate);
    if (baseline.fit.failed())
        throw core::NumericalError(core::FailureKind::FitFailed,
                                   "the model cannot be fitted: " + baseline.fit.reason);
    Search search(baseline, options);
    State found = search.find();
    // The noise was estimated about the chain alone, and what that lacks is not all at the lines
    // which the estimate leaves out: a clamp with friction was refused because of it.
    std::optional<fit::BaselineFit> again;
    if (found.model.names.size() > baseline.fit.names.size()) {
        fit::Fit& stated = found.ladder.back().stated;
        stated =
            fit::as_stated(found.model, baseline.stated, baseline.recordings, options.candidate);
        again = fit::baseline_beside_noise_of(stated, baseline, recordings, options.candidate);
    }
    if (!again || again->fit.failed())
        return search.answer(std::move(found));
    if (options.progress)
        options.progress("searching again beside the noise that this model leaves");
    Search second(*again, options);
    Diagnosis result = second.answer(second.find());
    result.runs += search.runs();
    return result;
}

} // namespace culm::diagnose
