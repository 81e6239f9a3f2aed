// SPDX-License-Identifier: BSD-3-Clause
#include "diagnose/answer.hpp"

#include "diagnose/candidate_field.hpp"
#include "diagnose/criterion.hpp"
#include "diagnose/judge.hpp"
#include "fit/coarse_image.hpp"
#include "fit/solve/residual_statistics.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <boost/math/special_functions/beta.hpp>
#include <fmt/core.h>
#include <fmt/ranges.h>

namespace culm::diagnose {
namespace {

std::vector<std::string> named(const Found& found) {
    return names_behind(found.model, found.options.known.size());
}

/// Share of the misfit above the noise that is gone.
double explained_share(const Found& found) {
    const fit::Fit& end = found.model;
    if (!end.is_noise_known_anywhere())
        return 1.0 - std::pow(end.rmse / found.start.rmse, 2);
    // A recording that does not state its noise has no misfit above it: its χ² is its readings.
    const double excess = found.start.chi_squared - static_cast<double>(found.start.readings);
    return excess > 0.0 ? std::min((found.start.chi_squared - end.chi_squared) / excess, 1.0) : 0.0;
}

/// Do the effects explain so much that they are named beside the structure that is left? The misfit
/// above the noise is a χ² less its mean, which scatters by √(2n): so well is the share known.
bool explains_nearly_all(const Found& found, double share) {
    const Policy& policy = found.options.policy;
    if (named(found).size() > policy.most_effects_beside_structure)
        return false;
    if (found.is_one_law || !found.start.is_noise_known_anywhere())
        return share >= policy.share_beside_structure;
    const auto readings = static_cast<double>(found.start.readings);
    const double excess = found.start.chi_squared - readings;
    return share - policy.share_certainty * std::sqrt(2.0 * readings) / excess >=
           policy.share_beside_structure;
}

/// What of the answer turned out to be absent, or at a bound, once the rest had joined; empty if
/// nothing did.
std::string fallen_obstacle(const Found& found, const std::vector<std::string>& effects) {
    for (const std::string& effect : effects)
        if (const Judgement own = judge_effect(found.model, effect); !own.is_accepted())
            return in_words(own);
    return {};
}

/// Which conclusion follows from the model that was reached.
ConclusionReason reason_of(const Found& found, const Diagnosis& result) {
    const Policy& policy = found.options.policy;
    const SearchedModel& last = result.ladder.back();
    const std::vector<std::string> effects = named(found);
    const bool is_adequate = last.finding == Finding::Adequate;
    if (effects.empty()) {
        if (is_adequate)
            return ConclusionReason::ResidualsAreNoise;
        if (last.finding == Finding::Undecided)
            return ConclusionReason::RecordingCannotTell;
        return last.p_value >= policy.clear_failure_level ? ConclusionReason::FailsAsNoiseMay
                                                          : ConclusionReason::NothingExplains;
    }
    if (!is_adequate && !explains_nearly_all(found, result.explained))
        return ConclusionReason::StructureIsLeft;
    if (!fallen_obstacle(found, effects).empty())
        return ConclusionReason::EffectHasFallen;
    return is_adequate ? ConclusionReason::ExplainsAll : ConclusionReason::ExplainsNearlyAll;
}

Conclusion conclusion_of(ConclusionReason reason, bool is_tie) {
    switch (reason) {
    case ConclusionReason::ResidualsAreNoise:
    case ConclusionReason::FailsAsNoiseMay:
        return Conclusion::Adequate;
    case ConclusionReason::ExplainsAll:
    case ConclusionReason::ExplainsNearlyAll:
        return is_tie ? Conclusion::Tie : Conclusion::Effect;
    default:
        return Conclusion::Unknown;
    }
}

/// The only place that words conclusions.
std::string in_words(ConclusionReason reason, const Found& found, const Diagnosis& result) {
    const SearchedModel& last = result.ladder.back();
    const std::vector<std::string> effects = named(found);
    const double percent = 100.0 * result.explained;
    switch (reason) {
    case ConclusionReason::ResidualsAreNoise:
        return "the residuals are noise";
    case ConclusionReason::FailsAsNoiseMay:
        return fmt::format("{} objects (p = {:.2g}), which one recording of noise in {:.0f} does "
                           "too, and no candidate explains it",
                           last.tests, last.p_value, 1.0 / last.p_value);
    case ConclusionReason::RecordingCannotTell:
        return last.tests;
    case ConclusionReason::NothingExplains:
        return "no candidate explains the residuals of the published chain";
    case ConclusionReason::StructureIsLeft:
        return fmt::format("{} explains {:.1f} % of the misfit, but its residuals are not noise "
                           "({})",
                           fmt::join(effects, " with "), percent, last.tests);
    case ConclusionReason::EffectHasFallen:
        return fmt::format("{} explains {:.1f} % of the misfit, but {}",
                           fmt::join(effects, " with "), percent, fallen_obstacle(found, effects));
    case ConclusionReason::ExplainsAll:
        return "with it the residuals are noise";
    case ConclusionReason::ExplainsNearlyAll:
        return fmt::format("it explains {:.2f} % of the misfit; the residuals are not noise ({})",
                           percent, last.tests);
    }
    return {};
}

const physics::Effect& rival(const fit::Fit& model) {
    return *model.effects.back().effect;
}

bool is_of_one_family(const Rivals& rivals) {
    const physics::Family family = rivals.effect.effect->family();
    return family != physics::Family::Own &&
           std::ranges::all_of(rivals.models, [&](const fit::Fit& model) {
               return rival(model).family() == family;
           });
}

/// What is certain of the answer: its effects, or their families where others of these do as well.
std::vector<NamedFamily> certain_families(const Found& found) {
    std::vector<NamedFamily> families;
    for (std::size_t k = found.options.known.size(); k < found.model.effects.size(); ++k) {
        const physics::Effect& effect = *found.model.effects[k].effect;
        NamedFamily own{effect.family(), {effect.name()}};
        const auto rivals = std::ranges::find_if(found.rivals, [&](const Rivals& group) {
            return group.effect.effect->name() == effect.name();
        });
        if (rivals != found.rivals.end()) {
            if (!is_of_one_family(*rivals))
                continue;
            for (const fit::Fit& model : rivals->models)
                own.members.push_back(rival(model).name());
        }
        const auto same = std::ranges::find(families, own.family, &NamedFamily::family);
        if (same == families.end() || !physics::is_one_law(own.family)) {
            families.push_back(std::move(own));
            continue;
        }
        for (std::string& member : own.members)
            if (std::ranges::find(same->members, member) == same->members.end())
                same->members.push_back(std::move(member));
    }
    return families;
}

void add_conclusion(const Found& found, Diagnosis& result) {
    const std::vector<std::string> effects = named(found);
    result.explained = effects.empty() ? 0.0 : explained_share(found);
    const ConclusionReason reason = reason_of(found, result);
    result.conclusion =
        conclusion_of(reason, !std::ranges::all_of(found.rivals, &is_of_one_family));
    result.reason = in_words(reason, found, result);
    if (result.conclusion != Conclusion::Effect && result.conclusion != Conclusion::Tie)
        return;
    result.effects = effects;
    result.families = certain_families(found);
    if (found.is_one_law)
        result.reason += "; a law between these would explain it, as both together do";
    for (const Rivals& rivals : found.rivals) {
        TieGroup group{
            {rivals.effect.effect->name()}, is_of_one_family(rivals), rivals.delta_bic, {}};
        for (const fit::Fit& model : rivals.models)
            group.names.push_back(rival(model).name());
        group.separate_by = rivals.effect.effect->remedy();
        result.ties.push_back(std::move(group));
    }
}

double cosine(const EffectScore& a, const EffectScore& b) {
    if (a.direction.size() != b.direction.size())
        return 0.0;
    double sum = 0.0;
    for (std::size_t k = 0; k < a.direction.size(); ++k)
        sum += a.direction[k] * b.direction[k];
    return std::abs(sum);
}

void rank(const Found& found, Diagnosis& result) {
    std::vector<fit::Fit> fits{found.start};
    for (const fit::Fit& model : found.first.models)
        fits.push_back(model);
    const Criterion by = criterion(fits);
    const auto tried = static_cast<double>(found.first.scores.size());
    for (const EffectScore& score : found.first.scores) {
        RankedEffect entry;
        entry.effect = score.effect;
        const fit::Fit* const model =
            single_of(found.first.models, score.effect, found.options.known.size());
        // A fit that was stopped above the model it contains says less than its score.
        const bool tells = model != nullptr &&
                           !(model->out_of_reach && model->chi_squared > found.start.chi_squared);
        if (tells) {
            entry.fit = *model;
            entry.is_refitted = true;
            entry.obstacle = model->out_of_reach
                                 ? "fit stopped: could not have matched the best model"
                                 : in_words(judge_effect(*model, score.effect));
            if (model->is_fitted()) {
                entry.delta_bic = bic(*model, by) - bic(found.start, by);
                entry.p_value = std::min(1.0, tried * gain_p_value(found.start, *model, by));
            } else {
                entry.delta_bic = std::numeric_limits<double>::infinity();
            }
        } else {
            const double gain = score.gain / by.inflation * by.share;
            entry.delta_bic = score.added * std::log(by.effective_readings) - gain;
            entry.p_value = std::min(1.0, tried * gain_p_value(gain, score.added));
            entry.obstacle = score.failure;
        }
        if (const auto refused = found.refused.find(score.effect);
            refused != found.refused.end() && entry.obstacle.empty())
            entry.obstacle = refused->second;
        for (const EffectScore& other : found.first.scores)
            if (other.effect != score.effect && !score.is_beyond_bounds &&
                !other.is_beyond_bounds &&
                cosine(score, other) > found.options.policy.similar_signature)
                entry.looks_like.push_back(other.effect);
        result.ranking.push_back(std::move(entry));
    }
    for (RankedEffect& entry : result.ranking)
        for (const physics::SelectedEffect& candidate : found.candidates)
            if (candidate.effect->name() == entry.effect)
                entry.signature = candidate.effect->signature();
    std::ranges::stable_sort(result.ranking, {}, &RankedEffect::delta_bic);
}

void count_false_names(const Found& found, Diagnosis& result) {
    const Policy& policy = found.options.policy;
    const Criterion by = criterion(found.model, {});
    const double price = std::log(by.effective_readings);
    const auto tried = static_cast<double>(result.blind_spots.size());
    std::vector<bool> is_named;
    for (const EffectScore& score : result.blind_spots) {
        is_named.resize(std::max(is_named.size(), score.null_gains.size()), false);
        for (std::size_t draw = 0; draw < score.null_gains.size(); ++draw) {
            const double gain = score.null_gains[draw] * by.share; // as the search counts it
            if (gain - score.added * price >= policy.naming_gain &&
                tried * gain_p_value(gain, score.added) < policy.naming_level)
                is_named[draw] = true;
        }
    }
    result.false_naming.draws = static_cast<int>(is_named.size());
    if (is_named.empty())
        return;
    const auto draws = static_cast<double>(is_named.size());
    const auto hits = static_cast<double>(std::ranges::count(is_named, true));
    result.false_naming.rate = hits / draws;
    result.false_naming.upper_bound =
        hits < draws ? boost::math::ibeta_inv(hits + 1.0, draws - hits, 0.975) : 1.0;
}

/// A model with a candidate of the size at which the record at hand would just show it.
fit::Fit just_visible(const Found& found, const physics::SelectedEffect& candidate,
                      const EffectScore& score) {
    fit::Fit model = found.model;
    model.effects.push_back(candidate);
    model.names = fit::model_names(fit::in_library_order(model.effects));
    fit::FittedParameter size;
    size.id = {score.effect, score.parameter, {}};
    size.value = score.smallest_visible;
    model.parameters.push_back(std::move(size));
    return model;
}

/// The answer against what it could be taken for; without rivals, against what would do most harm
/// unseen.
std::vector<std::pair<Rival, Rival>> pairs_to_separate(const Found& found,
                                                       const Diagnosis& result) {
    std::vector<std::pair<Rival, Rival>> pairs;
    const Rival answer{found.model, {}};
    for (const Rivals& rivals : found.rivals)
        for (const fit::Fit& model : rivals.models)
            if (pairs.size() < found.options.policy.most_pairs_to_separate)
                pairs.push_back({answer, {model, {}}});
    if (!pairs.empty() || result.conclusion == Conclusion::Unknown)
        return pairs;
    std::vector<const EffectScore*> harmful;
    for (const EffectScore& score : result.blind_spots)
        if (score.failure.empty() && !score.is_beyond_bounds && !score.parameter.empty())
            harmful.push_back(&score);
    std::ranges::stable_sort(harmful, std::greater{}, [](const EffectScore* score) {
        return std::max(std::abs(score->youngs_modulus_bias), std::abs(score->damping_bias));
    });
    for (const EffectScore* score : harmful)
        for (const physics::SelectedEffect& candidate : found.candidates)
            // None of the changes bears on what leaves the plane, and its fit takes as long as all
            // the rest.
            if (candidate.effect->name() == score->effect &&
                pairs.size() < found.options.policy.most_pairs_to_separate &&
                candidate.effect->dimensions() < 3) {
                const fit::Fit with = just_visible(found, candidate, *score);
                pairs.push_back({{with, score->effect}, answer});
            }
    return pairs;
}

} // namespace

void complete(const Found& found, Diagnosis& result) {
    add_conclusion(found, result);
    rank(found, result);
    count_false_names(found, result);
    std::vector<std::pair<Rival, Rival>> pairs = pairs_to_separate(found, result);
    if (!pairs.empty()) {
        if (found.options.progress)
            found.options.progress("computing which experiment distinguishes best");
        const fit::CoarseImage image(result.final_fit, found.recordings, found.options.candidate);
        for (auto& [truth, other] : pairs) {
            truth.fit = image.as_coarse(std::move(truth.fit));
            other.fit = image.as_coarse(std::move(other.fit));
        }
        result.next_experiments = next_experiments(
            pairs, image.recordings(), image.options(found.options.candidate), found.options.map);
    }
    if (result.conclusion == Conclusion::Unknown &&
        result.ladder.back().finding == Finding::Inadequate) {
        if (found.options.progress)
            found.options.progress("reconstructing the missing force");
        // What helped in part may be the wrong name for it: the force is all that is missing.
        result.missing_force = reconstruct_missing_force(result.baseline, found.options.known,
                                                         found.recordings, found.options.candidate);
    }
}

std::string_view to_string(Conclusion conclusion) {
    switch (conclusion) {
    case Conclusion::Adequate:
        return "adequate";
    case Conclusion::Effect:
        return "effect";
    case Conclusion::Tie:
        return "tie";
    case Conclusion::Unknown:
        return "unknown";
    }
    return "unknown";
}

} // namespace culm::diagnose
