// SPDX-License-Identifier: BSD-3-Clause
#include "diagnose/candidate_field.hpp"

#include "core/error.hpp"
#include "diagnose/criterion.hpp"
#include "fit/coarse_image.hpp"
#include "physics/effects/library.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

namespace culm::diagnose {
namespace {

const EffectScore* score_of(const fit::SelectedEffects& model,
                            const std::vector<EffectScore>& scores) {
    const auto found = std::ranges::find(scores, model.back().effect->name(), &EffectScore::effect);
    return found == scores.end() || !found->failure.empty() ? nullptr : &*found;
}

} // namespace

const fit::Fit* ModelMemory::fit_of(const fit::SelectedEffects& effects) const {
    const auto found = fits_.find(key_of(effects));
    return found == fits_.end() ? nullptr : &found->second;
}

void ModelMemory::keep(const fit::SelectedEffects& effects, const fit::Fit& fit) {
    if (!fit.is_fitted())
        return;
    const auto [place, is_new] = fits_.try_emplace(key_of(effects), fit);
    if (!is_new && fit.chi_squared < place->second.chi_squared)
        place->second = fit;
}

const std::vector<EffectScore>*
ModelMemory::scores_beside(const fit::SelectedEffects& effects) const {
    const auto found = scores_.find(key_of(effects));
    return found == scores_.end() ? nullptr : &found->second;
}

void ModelMemory::keep(const fit::SelectedEffects& effects,
                       const std::vector<EffectScore>& scores) {
    scores_.insert_or_assign(key_of(effects), scores);
}

// Names with fixed values, sorted: the order in which effects were found does not matter, but a
// value that the user fixed makes another model.
ModelMemory::Key ModelMemory::key_of(const fit::SelectedEffects& effects) {
    Key key;
    for (const physics::SelectedEffect& selected : effects) {
        std::string& text = key.emplace_back(physics::to_string(selected));
        for (const std::string& recording : selected.absent_from)
            text += " without " + recording;
    }
    std::ranges::sort(key);
    return key;
}

bool can_be_combined(const fit::SelectedEffects& effects) {
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

std::vector<fit::SelectedEffects> pairs_of_best(std::vector<fit::Fit> singles, std::size_t count) {
    std::erase_if(singles, [](const fit::Fit& model) { return !model.is_fitted(); });
    std::ranges::stable_sort(singles, is_likelier);
    singles.resize(std::min(singles.size(), count));
    std::vector<fit::SelectedEffects> pairs;
    for (std::size_t a = 0; a < singles.size(); ++a)
        for (std::size_t b = a + 1; b < singles.size(); ++b) {
            fit::SelectedEffects both = singles[a].effects;
            both.push_back(singles[b].effects.back());
            if (can_be_combined(both))
                pairs.push_back(std::move(both));
        }
    return pairs;
}

const fit::Fit* single_of(const std::vector<fit::Fit>& models, const std::string& effect,
                          std::size_t known) {
    const auto found = std::ranges::find_if(models, [&](const fit::Fit& model) {
        return model.effects.size() == known + 1 && model.effects.back().effect->name() == effect;
    });
    return found == models.end() ? nullptr : &*found;
}

std::vector<std::string> names_behind(const fit::Fit& model, std::size_t count) {
    std::vector<std::string> names;
    for (std::size_t k = count; k < model.effects.size(); ++k)
        names.push_back(model.effects[k].effect->name());
    return names;
}

CandidateField::CandidateField(std::span<const fit::ObservedRecording> recordings,
                               const DiagnosisOptions& options)
    : recordings_(recordings), options_(options),
      candidates_(fit::in_library_order(options.candidates)) {
    std::erase_if(candidates_,
                  [&](const auto& candidate) { return fit::contains(options.known, candidate); });
}

fit::Fit CandidateField::fit(const fit::SelectedEffects& effects, const fit::Fit& smaller) {
    return keep(effects, fit::fit_model(effects, smaller, recordings_, options_.candidate));
}

fit::Fit CandidateField::keep(const fit::SelectedEffects& effects, fit::Fit fit) {
    runs_ += fit.runs;
    if (fit.failed())
        throw core::NumericalError(core::FailureKind::FitFailed,
                                   "the model cannot be fitted: " + fit.reason);
    memory_.keep(effects, fit::numbers_of(fit));
    return fit;
}

fit::Fit CandidateField::recall(const fit::SelectedEffects& effects, const fit::Fit& smaller) {
    if (const fit::Fit* const known =
            remembered(effects, smaller, std::numeric_limits<double>::infinity())) {
        fit::Fit model = *known;
        model.effects = effects;
        return restore(model);
    }
    fit::Fit found = fit_anew({effects}, smaller, {}).front();
    return found.failed() ? found : restore(found);
}

/// A larger model that was met on another way may have ended above this smaller one, or was not
/// followed as far as what is wanted now.
const fit::Fit* CandidateField::remembered(const fit::SelectedEffects& effects,
                                           const fit::Fit& smaller, double wanted) const {
    const fit::Fit* const known = memory_.fit_of(effects);
    const bool is_usable = known != nullptr && known->chi_squared <= smaller.chi_squared &&
                           (!known->out_of_reach || wanted <= *known->out_of_reach);
    return is_usable ? known : nullptr;
}

fit::Fit CandidateField::restore(const fit::Fit& model) {
    fit::Fit fit = fit::restored(model, recordings_, options_.candidate);
    runs_ += fit.runs;
    return fit;
}

std::vector<EffectScore> CandidateField::score(const fit::Fit& base,
                                               const fit::SelectedEffects& effects, int draws) {
    if (const auto* const known = memory_.scores_beside(effects); known != nullptr && draws == 0)
        return *known;
    fit::SelectedEffects wanted;
    std::vector<double> costs;
    for (const physics::SelectedEffect& candidate : candidates_) {
        fit::SelectedEffects larger = effects;
        larger.push_back(candidate);
        if (fit::contains(effects, candidate) || !can_be_combined(larger))
            continue;
        wanted.push_back(candidate);
        costs.push_back(fit::relative_cost(larger));
    }
    // On the coarse image: a score is one linear step, and its own error is larger than the
    // image's.
    const fit::CoarseImage image(base, recordings_, options_.candidate);
    std::vector<std::optional<EffectScore>> answers =
        options_.map.values(costs, [&](std::size_t item, const run::Heartbeat& heartbeat) {
            return score_effect(image.fit(), wanted[item], image.recordings(),
                                image.options(with_heartbeat(options_.candidate, heartbeat)),
                                draws);
        });
    std::vector<EffectScore> scores;
    for (std::size_t k = 0; k < wanted.size(); ++k) {
        EffectScore lost;
        lost.failure = "the rank that computed it was lost";
        scores.push_back(std::move(answers[k]).value_or(std::move(lost)));
        scores.back().effect = wanted[k].effect->name();
    }
    memory_.keep(effects, scores);
    return scores;
}

std::vector<fit::SelectedEffects> CandidateField::one_more(const fit::SelectedEffects& effects,
                                                           const std::vector<EffectScore>& scores,
                                                           double least_gain,
                                                           bool only_best) const {
    const Policy& policy = options_.policy;
    double best = 0.0;
    for (const EffectScore& score : scores)
        best = std::max(best, score.gain);
    std::vector<fit::SelectedEffects> models;
    for (const physics::SelectedEffect& candidate : candidates_) {
        fit::SelectedEffects larger = effects;
        larger.push_back(candidate);
        if (fit::contains(effects, candidate) || !can_be_combined(larger))
            continue;
        const EffectScore* const score = score_of(larger, scores);
        const bool is_spatial = fit::relative_cost({candidate}) > 1.0;
        // A spatial fit takes six times as long as a planar one: it has to promise more, and
        // something even where every planar candidate is fitted.
        const double share = only_best ? (is_spatial ? policy.least_promised_share_spatial
                                                     : policy.least_promised_share)
                                       : (is_spatial ? policy.least_promised_share : 0.0);
        // A score that failed says nothing: the fit must tell.
        if (score == nullptr || score->gain >= std::max(least_gain, share * best))
            models.push_back(std::move(larger));
    }
    return models;
}

std::vector<fit::SelectedEffects>
CandidateField::in_fewer_recordings(const fit::SelectedEffects& effects, std::size_t count) const {
    std::vector<fit::SelectedEffects> models;
    for (std::size_t k = count; k < effects.size(); ++k) {
        const std::vector<std::string>& absent = effects[k].absent_from;
        if (!fit::belongs_to_recording({effects[k].effect->name(), {}, {}}) ||
            absent.size() + 1 >= recordings_.size())
            continue;
        for (const measure::Measurement& recording : recordings_)
            // One recording at a time: the search comes back for the next.
            if (std::ranges::find(absent, recording.stem.id) == absent.end())
                models.emplace_back(effects)[k].absent_from.push_back(recording.stem.id);
    }
    return models;
}

std::vector<fit::Fit> CandidateField::fit_promising(const std::vector<fit::SelectedEffects>& models,
                                                    const std::vector<EffectScore>& scores,
                                                    const fit::Fit& smaller, double gained) {
    // The cheap planar fits first: what they gain decides which spatial ones are worth their time.
    std::vector<fit::SelectedEffects> spatial;
    std::vector<fit::SelectedEffects> planar;
    for (const fit::SelectedEffects& model : models)
        (fit::relative_cost({model.back()}) > 1.0 ? spatial : planar).push_back(model);
    std::vector<fit::Fit> fitted = fit_all(planar, smaller, smaller.chi_squared - gained);
    for (const fit::Fit& model : fitted)
        if (model.is_fitted())
            gained = std::max(gained, smaller.chi_squared - model.chi_squared);
    const double slack =
        options_.policy.overtaking_slack *
        std::max(1.0, (smaller.chi_squared - gained) / static_cast<double>(smaller.readings));
    std::erase_if(spatial, [&](const fit::SelectedEffects& model) {
        const EffectScore* const score = score_of(model, scores);
        return score != nullptr && score->gain + slack < options_.policy.overtaking_share * gained;
    });
    std::ranges::move(fit_all(spatial, smaller, smaller.chi_squared - gained),
                      std::back_inserter(fitted));
    return fitted;
}

std::vector<fit::Fit> CandidateField::fit_all(const std::vector<fit::SelectedEffects>& models,
                                              const fit::Fit& smaller, double wanted_chi_squared) {
    std::vector<fit::Fit> fitted;
    std::vector<fit::SelectedEffects> unmet;
    std::vector<std::size_t> places;
    for (const fit::SelectedEffects& model : models) {
        fit::Fit& known = fitted.emplace_back();
        if (const fit::Fit* const fit = remembered(model, smaller, wanted_chi_squared)) {
            known = *fit;
            known.effects = model; // in the order in which they were found now
        } else {
            unmet.push_back(model);
            places.push_back(fitted.size() - 1);
        }
    }
    std::vector<fit::Fit> found = fit_anew(unmet, smaller, {wanted_chi_squared, true});
    for (std::size_t k = 0; k < found.size(); ++k)
        fitted[places[k]] = std::move(found[k]);
    return fitted;
}

std::vector<fit::Fit> CandidateField::followed(std::vector<fit::Fit> models,
                                               const fit::Fit& smaller,
                                               double largest_chi_squared) {
    const auto may_come_below = [&](const fit::Fit& model) {
        return model.out_of_reach && *model.out_of_reach < largest_chi_squared;
    };
    std::vector<fit::SelectedEffects> unfinished;
    for (const fit::Fit& model : models)
        if (may_come_below(model))
            unfinished.push_back(model.effects);
    auto found = fit_anew(unfinished, smaller, {largest_chi_squared});
    auto next = found.begin();
    for (fit::Fit& model : models)
        if (may_come_below(model))
            model = std::move(*next++);
    return models;
}

std::vector<fit::Fit> CandidateField::fit_anew(const std::vector<fit::SelectedEffects>& models,
                                               const fit::Fit& smaller, const fit::FitGoal& goal) {
    std::vector<fit::Fit> fits =
        fit::fit_candidates(models, smaller, recordings_, options_.candidate, options_.map, goal);
    for (std::size_t k = 0; k < models.size(); ++k) {
        runs_ += fits[k].runs;
        memory_.keep(models[k], fits[k]);
    }
    return fits;
}

} // namespace culm::diagnose
