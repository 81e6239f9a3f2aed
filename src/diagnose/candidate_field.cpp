// SPDX-License-Identifier: BSD-3-Clause
#include "diagnose/candidate_field.hpp"

#include "core/error.hpp"
#include "diagnose/coarse_image.hpp"
#include "physics/effects/library.hpp"

#include <algorithm>
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

const SearchedModel* single_of(const std::vector<SearchedModel>& models, const std::string& effect,
                               std::size_t known) {
    const auto found = std::ranges::find_if(models, [&](const SearchedModel& model) {
        return model.effects.size() == known + 1 && model.effects.back().effect->name() == effect;
    });
    return found == models.end() ? nullptr : &*found;
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
        costs.push_back(relative_cost(larger));
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
        const bool is_spatial = relative_cost({candidate}) > 1.0;
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
        (relative_cost({model.back()}) > 1.0 ? spatial : planar).push_back(model);
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

std::vector<SearchedModel> CandidateField::fit_anew(const std::vector<SelectedEffects>& models,
                                                    const ModelFit& smaller, const FitGoal& goal) {
    std::vector<FitSummary> fits =
        fit_candidates(models, smaller, recordings_, options_.candidate, options_.map, goal);
    std::vector<SearchedModel> fitted;
    for (std::size_t k = 0; k < models.size(); ++k) {
        runs_ += fits[k].runs;
        memory_.keep(models[k], fits[k]);
        fitted.push_back({models[k], std::move(fits[k])});
    }
    return fitted;
}

} // namespace culm::diagnose
