// SPDX-License-Identifier: BSD-3-Clause
#include "diagnose/candidate_field.hpp"

#include "core/error.hpp"
#include "physics/effects/library.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

namespace culm::diagnose {
namespace {

/// Of the best promise; a linear promise may be far off, but a rival in a tie keeps this much. Fits
/// of spatial chains take most of the time: they have to promise more unless nothing else is left.
constexpr double least_share = 0.05;
constexpr double least_spatial_share = 0.6;
/// Of what another model gains, that the score of a spatial one has to promise: it is one linear
/// step from the beats that the readings show, and near what a fit brings if there are any.
constexpr double overtaking_share = 0.9;
/// Of χ², in units of the best model's reduced χ²: where so little decides, a step says too little.
constexpr double overtaking_slack = 50.0;
/// Of what a fit gains, that may be missing on a coarse chain: 1.4 % were seen of a friction that
/// takes 97 % of a misfit of 30 times the noise.
constexpr double image_error = 0.02;
/// Reduced χ² of a fit that can only be a step on the way: a coarse chain tells it well enough.
constexpr double step_misfit = 25.0;
/// Spatial chains cost some six times as much as planar ones.
constexpr double spatial_cost = 6.0;

double cost_of(const SelectedEffects& effects) {
    return std::ranges::any_of(effects,
                               [](const auto& each) { return each.effect->dimensions() > 2; })
               ? spatial_cost
               : 1.0;
}

/// χ² so far above `best` that a model that does not come down to it is neither better nor a rival:
/// what decides is a few dozen, counted by the best model's reduced χ² and by the share of the
/// readings that are independent.
double within_reach(double best, std::size_t readings) {
    constexpr double generous = 300.0;
    return best +
           generous * std::max(1.0, best / static_cast<double>(std::max<std::size_t>(readings, 1)));
}

double smallest_begun(const std::vector<std::vector<std::string>>& begun) {
    double smallest = std::numeric_limits<double>::infinity();
    for (const std::vector<std::string>& starts : begun)
        for (const std::string& start : starts)
            smallest = std::min(smallest, FitPlan::chi_squared_of(start));
    return smallest;
}

const EffectScore* score_of(const SelectedEffects& model, const std::vector<EffectScore>& scores) {
    const auto found = std::ranges::find(scores, model.back().effect->name(), &EffectScore::effect);
    return found == scores.end() || !found->failure.empty() ? nullptr : &*found;
}

} // namespace

bool contains(const SelectedEffects& effects, const physics::SelectedEffect& wanted) {
    return std::ranges::any_of(
        effects, [&](const auto& each) { return each.effect->name() == wanted.effect->name(); });
}

bool can_be_combined(const SelectedEffects& effects) {
    std::vector<physics::EffectPointer> pointers;
    for (const physics::SelectedEffect& selected : effects)
        pointers.push_back(selected.effect);
    try {
        physics::check_combination(pointers);
    } catch (const core::InputError&) {
        return false;
    }
    return true;
}

std::vector<SelectedEffects> pairs_of_best(std::vector<SearchedModel> singles, std::size_t count) {
    std::erase_if(singles, [](const SearchedModel& model) { return !model.fit.is_fitted(); });
    std::ranges::stable_sort(singles, {},
                             [](const SearchedModel& model) { return model.fit.rmse; });
    singles.resize(std::min(singles.size(), count));
    std::vector<SelectedEffects> pairs;
    for (std::size_t a = 0; a < singles.size(); ++a)
        for (std::size_t b = a + 1; b < singles.size(); ++b) {
            SelectedEffects both = singles[a].effects;
            both.push_back(singles[b].effects.back());
            if (can_be_combined(both))
                pairs.push_back(std::move(both));
        }
    return pairs;
}

CandidateField::CandidateField(std::span<const measure::Measurement> recordings,
                               const DiagnosisOptions& options)
    : recordings_(recordings), options_(options),
      candidates_(in_library_order(options.candidates.empty() ? candidate_effects(recordings)
                                                              : options.candidates)) {
    std::erase_if(candidates_,
                  [&](const auto& candidate) { return contains(options.known, candidate); });
}

CandidateOptions CandidateField::with(const run::Heartbeat& heartbeat) const {
    CandidateOptions own = options_.candidate;
    if (heartbeat)
        own.heartbeat = heartbeat;
    return own;
}

ModelFit CandidateField::fit(const SelectedEffects& effects, const ModelFit& smaller) {
    ModelFit fit = fit_model(effects, smaller, recordings_, options_.candidate);
    runs_ += fit.runs;
    if (!fit.is_fitted())
        throw core::NumericalError(core::FailureKind::FitFailed,
                                   "the model cannot be fitted: " + fit.failure);
    memory_.keep(effects, summary_of(fit));
    return fit;
}

ModelFit CandidateField::recall(const SelectedEffects& effects, const ModelFit& smaller) {
    if (const FitSummary* const known =
            remembered(effects, smaller, std::numeric_limits<double>::infinity()))
        return restore({effects, *known});
    SearchedModel found = fit_anew({effects}, smaller, {}).front();
    ModelFit fit;
    if (found.fit.failure.empty())
        fit = restore(found);
    fit.names = found.fit.names;
    fit.failure = found.fit.failure;
    fit.moves = found.fit.moves;
    return fit;
}

/// A larger model that was met on another way may have ended above this smaller one, or was not
/// followed as far as what is wanted now.
const FitSummary* CandidateField::remembered(const SelectedEffects& effects,
                                             const ModelFit& smaller, double wanted) const {
    const FitSummary* const known = memory_.fit_of(effects);
    const bool is_usable = known != nullptr && known->chi_squared <= smaller.chi_squared &&
                           (!known->out_of_reach || wanted <= *known->out_of_reach);
    return is_usable ? known : nullptr;
}

ModelFit CandidateField::restore(const SearchedModel& model) {
    ModelFit fit = restored(model.fit, model.effects, recordings_, options_.candidate);
    runs_ += fit.runs;
    return fit;
}

std::vector<EffectScore> CandidateField::score(const ModelFit& base, const SelectedEffects& effects,
                                               int draws) {
    if (const auto* const known = memory_.scores_beside(effects); known != nullptr && draws == 0)
        return *known;
    SelectedEffects wanted;
    std::vector<double> costs;
    for (const physics::SelectedEffect& candidate : candidates_) {
        SelectedEffects larger = effects;
        larger.push_back(candidate);
        if (contains(effects, candidate) || !can_be_combined(larger))
            continue;
        wanted.push_back(candidate);
        costs.push_back(cost_of(larger));
    }
    const CoarseImage image(base, recordings_, options_.candidate);
    const std::vector<std::string> answers =
        options_.map(costs, [&](std::size_t item, const run::Heartbeat& heartbeat) {
            return to_text(score_effect(image.fit(), wanted[item], image.recordings(),
                                        image.options(with(heartbeat)), draws));
        });
    std::vector<EffectScore> scores;
    for (std::size_t k = 0; k < wanted.size(); ++k) {
        scores.push_back(score_from_text(answers[k]));
        scores.back().effect = wanted[k].effect->name();
    }
    memory_.keep(effects, scores);
    return scores;
}

std::vector<SelectedEffects> CandidateField::one_more(const SelectedEffects& effects,
                                                      const std::vector<EffectScore>& scores,
                                                      double least_gain, bool only_best) const {
    double best = 0.0;
    for (const EffectScore& score : scores)
        best = std::max(best, score.gain);
    std::vector<SelectedEffects> models;
    for (const physics::SelectedEffect& candidate : candidates_) {
        SelectedEffects larger = effects;
        larger.push_back(candidate);
        if (contains(effects, candidate) || !can_be_combined(larger))
            continue;
        const EffectScore* const score = score_of(larger, scores);
        const bool is_spatial = cost_of({candidate}) > 1.0;
        const double share = only_best ? (is_spatial ? least_spatial_share : least_share)
                                       : (is_spatial ? least_share : 0.0);
        // A score that failed says nothing: the fit must tell.
        if (score == nullptr || score->gain >= std::max(least_gain, share * best))
            models.push_back(std::move(larger));
    }
    return models;
}

std::vector<SelectedEffects> CandidateField::in_fewer_recordings(const SelectedEffects& effects,
                                                                 std::size_t count) const {
    std::vector<SelectedEffects> models;
    for (std::size_t k = count; k < effects.size(); ++k) {
        const std::vector<std::string>& absent = effects[k].absent_from;
        if (!belongs_to_recording(effects[k].effect->name() + '.') ||
            absent.size() + 1 >= recordings_.size())
            continue;
        for (const measure::Measurement& recording : recordings_)
            if (std::ranges::find(absent, recording.stem.id) == absent.end())
                models.emplace_back(effects)[k].absent_from.push_back(recording.stem.id);
    }
    return models;
}

std::vector<SearchedModel> CandidateField::fit_promising(const std::vector<SelectedEffects>& models,
                                                         const std::vector<EffectScore>& scores,
                                                         const ModelFit& smaller, double gained) {
    std::vector<SelectedEffects> spatial;
    std::vector<SelectedEffects> planar;
    for (const SelectedEffects& model : models)
        (cost_of({model.back()}) > 1.0 ? spatial : planar).push_back(model);
    std::vector<SearchedModel> fitted = fit_all(planar, smaller, smaller.chi_squared - gained);
    for (const SearchedModel& model : fitted)
        if (model.fit.is_fitted())
            gained = std::max(gained, smaller.chi_squared - model.fit.chi_squared);
    const double slack =
        overtaking_slack *
        std::max(1.0, (smaller.chi_squared - gained) / static_cast<double>(smaller.readings));
    std::erase_if(spatial, [&](const SelectedEffects& model) {
        const EffectScore* const score = score_of(model, scores);
        return score != nullptr && score->gain + slack < overtaking_share * gained;
    });
    std::ranges::move(fit_all(spatial, smaller, smaller.chi_squared - gained),
                      std::back_inserter(fitted));
    return fitted;
}

std::vector<SearchedModel> CandidateField::fit_all(const std::vector<SelectedEffects>& models,
                                                   const ModelFit& smaller,
                                                   double wanted_chi_squared) {
    std::vector<SearchedModel> fitted;
    std::vector<SelectedEffects> unmet;
    std::vector<std::size_t> places;
    for (const SelectedEffects& model : models) {
        SearchedModel& known = fitted.emplace_back(SearchedModel{model, {}});
        if (const FitSummary* const fit = remembered(model, smaller, wanted_chi_squared)) {
            known.fit = *fit;
        } else {
            unmet.push_back(model);
            places.push_back(fitted.size() - 1);
        }
    }
    std::vector<SearchedModel> found = fit_anew(unmet, smaller, {wanted_chi_squared, true});
    for (std::size_t k = 0; k < found.size(); ++k)
        fitted[places[k]] = std::move(found[k]);
    return fitted;
}

std::vector<SearchedModel> CandidateField::followed(std::vector<SearchedModel> models,
                                                    const ModelFit& smaller,
                                                    double largest_chi_squared) {
    const auto may_come_below = [&](const SearchedModel& model) {
        return model.fit.out_of_reach && *model.fit.out_of_reach < largest_chi_squared;
    };
    std::vector<SelectedEffects> unfinished;
    for (const SearchedModel& model : models)
        if (may_come_below(model))
            unfinished.push_back(model.effects);
    auto found = fit_anew(unfinished, smaller, {largest_chi_squared});
    auto next = found.begin();
    for (SearchedModel& model : models)
        if (may_come_below(model))
            model = std::move(*next++);
    return models;
}

/// (plans)(starts), as FitPlan::begin().
std::vector<std::vector<std::string>> CandidateField::begun_fits(const CoarseImage& image,
                                                                 const std::vector<FitPlan>& plans,
                                                                 const std::vector<double>& costs) {
    std::vector<std::pair<std::size_t, std::size_t>> items; // plan and start
    std::vector<double> item_costs;
    for (std::size_t k = 0; k < plans.size(); ++k)
        for (std::size_t start = 0; start < plans[k].start_count(); ++start) {
            items.emplace_back(k, start);
            item_costs.push_back(costs[k]);
        }
    std::vector<std::vector<std::string>> begun(plans.size());
    if (items.empty())
        return begun;
    const std::vector<std::string> answers =
        options_.map(item_costs, [&](std::size_t item, const run::Heartbeat& heartbeat) {
            return plans[items[item].first].begin(items[item].second,
                                                  image.options(with(heartbeat)));
        });
    for (std::size_t item = 0; item < items.size(); ++item)
        begun[items[item].first].push_back(answers[item]);
    return begun;
}

/// Fits that do not come within `reach` are told of by where they were.
std::vector<FitSummary> CandidateField::fit_image(const CoarseImage& image,
                                                  const std::vector<SelectedEffects>& models,
                                                  const Goal& goal, std::optional<double>& reach) {
    std::vector<FitPlan> plans;
    std::vector<double> costs;
    for (const SelectedEffects& effects : models) {
        plans.emplace_back(effects, image.fit(), image.recordings(),
                           image.options(options_.candidate));
        costs.push_back(cost_of(effects));
    }
    const std::vector<std::vector<std::string>> begun = begun_fits(image, plans, costs);
    const ModelFit& smaller = image.fit();
    const double aim =
        goal.is_of_best ? std::min(goal.chi_squared, smallest_begun(begun)) : goal.chi_squared;
    if (std::isfinite(aim) && smaller.is_fitted() && smaller.parts.front().is_noise_known)
        reach = (goal.is_of_best ? within_reach(aim, smaller.readings) : aim) +
                (image.is_coarser() ? image_error : 0.0) * std::max(0.0, smaller.chi_squared - aim);
    const std::vector<std::string> answers =
        options_.map(costs, [&](std::size_t item, const run::Heartbeat& heartbeat) {
            CandidateOptions own = image.options(with(heartbeat));
            own.wanted_chi_squared = reach;
            return to_text(image.as_fine(summary_of(plans[item].finish(begun[item], own))));
        });
    std::vector<FitSummary> fits;
    for (const std::string& answer : answers) {
        fits.push_back(summary_from_text(answer));
        runs_ += fits.back().runs;
    }
    return fits;
}

/// Follows what coarse chains have found with those that are asked for, as far as it matters.
void CandidateField::refine(const std::vector<SelectedEffects>& models, const ModelFit& smaller,
                            const std::optional<double>& reach, std::vector<FitSummary>& fits) {
    std::vector<std::size_t> places;
    std::vector<double> costs;
    for (std::size_t k = 0; k < fits.size(); ++k) {
        if (fits[k].is_fitted() && reach && fits[k].chi_squared > *reach)
            fits[k].out_of_reach = reach;
        const bool is_step = fits[k].is_fitted() && fits[k].reduced_chi_squared > step_misfit;
        if (fits[k].out_of_reach || !fits[k].moves || is_step)
            continue;
        places.push_back(k);
        costs.push_back(cost_of(models[k]));
    }
    const std::vector<std::string> answers =
        options_.map(costs, [&](std::size_t item, const run::Heartbeat& heartbeat) {
            const SelectedEffects& effects = models[places[item]];
            const FitSummary& coarse = fits[places[item]];
            const CandidateOptions own = with(heartbeat);
            return to_text(summary_of(coarse.is_fitted()
                                          ? refined(models_of(coarse, effects, recordings_, own),
                                                    effects, smaller, recordings_, own)
                                          : fit_model(effects, smaller, recordings_, own)));
        });
    for (std::size_t item = 0; item < places.size(); ++item) {
        FitSummary& fit = fits[places[item]];
        fit = summary_from_text(answers[item]);
        runs_ += fit.runs;
    }
}

std::vector<SearchedModel> CandidateField::fit_anew(const std::vector<SelectedEffects>& models,
                                                    const ModelFit& smaller, const Goal& goal) {
    if (models.empty())
        return {};
    const CoarseImage image(smaller, recordings_, options_.candidate);
    std::optional<double> reach;
    std::vector<FitSummary> fits = fit_image(image, models, goal, reach);
    if (image.is_coarser())
        refine(models, smaller, reach, fits);
    std::vector<SearchedModel> fitted;
    for (std::size_t k = 0; k < models.size(); ++k) {
        if (fits[k].names.empty())
            fits[k].names = model_names(in_library_order(models[k]));
        memory_.keep(models[k], fits[k]);
        fitted.push_back({models[k], std::move(fits[k])});
    }
    return fitted;
}

} // namespace culm::diagnose
