// SPDX-License-Identifier: BSD-3-Clause
#include "diagnose/diagnosis.hpp"

#include "core/error.hpp"
#include "diagnose/final_models.hpp"
#include "diagnose/planned_model.hpp"
#include "fit/fit_numbers.hpp"
#include "fit/start/coarse_chain.hpp"
#include "physics/effects/library.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <fmt/format.h>

namespace culm::diagnose {
namespace {

std::vector<std::string> names_of(const fit::SelectedEffects& effects,
                                  const DiagnosisOptions& options) {
    std::vector<std::string> names;
    for (std::size_t k = options.known.size(); k < effects.size(); ++k)
        names.push_back(effects[k].effect->name());
    return names;
}

fit::Fit fit_of(const SearchResult& search, std::size_t model, const DiagnosisOptions& options) {
    if (model == search.best)
        return search.best_fit;
    if (model == 0 && options.known.empty())
        return search.chain.fit;
    return fit::rerun(search.visited[model].fit, search.chain.recordings, options.candidate);
}

/// Was the model fitted with every other law of the library of the effect's family instead of it,
/// and does each fail the tests for lack of fit?
bool is_only_law(const SearchResult& search, std::size_t model, const std::string& effect) {
    const fit::SelectedEffects& effects = search.visited[model].fit.effects;
    const auto own = std::ranges::find_if(
        effects, [&](const auto& each) { return each.effect->name() == effect; });
    if (own == effects.end())
        return false;
    return std::ranges::all_of(physics::all_effects(), [&](const physics::EffectPointer& other) {
        if (other->name() == effect || other->family() != own->effect->family())
            return true;
        fit::SelectedEffects swapped = effects;
        swapped[static_cast<std::size_t>(own - effects.begin())] =
            physics::parse_effect(other->name(), {});
        return std::ranges::any_of(search.visited, [&](const VisitedModel& each) {
            return each.is_inadequate && key_of(each.fit.effects) == key_of(swapped);
        });
    });
}

/// The sets of families that hold 95 % of the probability, and the families common to all.
void add_alternatives(const SearchResult& search, const DiagnosisOptions& options, Diagnosis& out) {
    double held = 0.0;
    for (const FamilyExplanation& entry : out.posterior.by_family) {
        if (held >= options.policy.held_probability)
            break;
        held += entry.probability;
        FamilyExplanation& added = out.alternatives.emplace_back(entry);
        for (NamedFamily& named : added.families)
            named.is_open = physics::is_one_law(named.family) &&
                            !(named.members.size() == 1 &&
                              is_only_law(search, entry.model, named.members.front()));
    }
    out.families = out.alternatives.front().families;
    for (const FamilyExplanation& other : out.alternatives)
        std::erase_if(out.families, [&](const NamedFamily& named) {
            return std::ranges::find(other.families, named.family, &NamedFamily::family) ==
                   other.families.end();
        });
}

void add_model(const SearchResult& search, const DiagnosisOptions& options, std::size_t model,
               Diagnosis& out) {
    SearchedModel& added = out.ladder.emplace_back();
    added.fit = fit_of(search, model, options);
    const SetVerdict verdict = verdict_on(added.fit, search.chain.recordings, options.policy);
    added.finding = verdict.finding;
    added.p_value = verdict.p_value;
    added.tests = verdict.reason;
    added.log_evidence = search.visited[model].log_evidence - search.visited.front().log_evidence;
}

/// Steps from the published chain to the answer, via the best model with one of its effects.
void climb_to(const SearchResult& search, const DiagnosisOptions& options, std::size_t answer,
              Diagnosis& out) {
    add_model(search, options, 0, out);
    if (const auto part = likeliest_part(search, answer, options))
        add_model(search, options, *part, out);
    if (answer != 0)
        add_model(search, options, answer, out);
    out.final_fit = out.ladder.back().fit;
}

void add_residual(Diagnosis& out) {
    out.explained = explained_share(out.final_fit, out.ladder.front().fit);
    double squares = 0.0;
    double noise = 0.0;
    double swing = 0.0;
    double readings = 0.0;
    for (const fit::RecordingFit& part : out.final_fit.parts)
        for (std::size_t k = 0; k < part.residuals.size(); ++k) {
            const double measured = part.residuals[k] + part.prediction.readings[k];
            if (!std::isfinite(measured))
                continue;
            squares += part.residuals[k] * part.residuals[k];
            noise += part.is_noise_known ? std::pow(part.noise[k % part.prediction.rows], 2) : 0.0;
            swing += measured * measured;
            readings += 1.0;
        }
    out.unexplained = std::sqrt(std::max(0.0, squares - noise) / std::max(readings, 1.0));
    out.unexplained_share =
        swing > 0.0 ? out.unexplained / std::sqrt(swing / std::max(readings, 1.0)) : 0.0;
}

void conclude(const SearchResult& search, const DiagnosisOptions& options, Diagnosis& out) {
    const auto is_chain = [](const FamilyExplanation& each) { return each.families.empty(); };
    const bool chain_is_likely = std::ranges::any_of(out.alternatives, is_chain);
    const SearchedModel& last = out.ladder.back();
    if (leaves_too_much(last.fit, out.ladder.front().fit, search.chain.recordings,
                        options.policy)) {
        out.conclusion = Conclusion::Unknown;
        out.reason = fmt::format(
            "the best model fails the tests for lack of fit{} and leaves {:.0f} % of the misfit",
            last.tests.empty() ? "" : fmt::format(" ({})", last.tests),
            100.0 * (1.0 - out.explained));
    } else if (chain_is_likely && out.ladder.front().finding == Finding::Undecided) {
        out.conclusion = Conclusion::Unknown;
        out.reason = out.ladder.front().tests;
    } else if (chain_is_likely) {
        out.conclusion = Conclusion::Adequate;
        out.reason = "no other explanation is needed for 95 % of the probability";
    } else {
        out.conclusion = out.alternatives.size() == 1 ? Conclusion::Effect : Conclusion::Tie;
        out.reason = out.conclusion == Conclusion::Effect
                         ? "these effects hold 95 % of the probability"
                         : fmt::format("{} explanations are needed for 95 % of the "
                                       "probability",
                                       out.alternatives.size());
    }
    if (out.conclusion == Conclusion::Effect || out.conclusion == Conclusion::Tie)
        out.effects = names_of(search.visited[out.alternatives.front().model].fit.effects, options);
    else
        out.families.clear();
    out.probability = out.alternatives.front().probability;
    if (out.conclusion == Conclusion::Adequate)
        out.probability = std::ranges::find_if(out.alternatives, is_chain)->probability;
}

/// A model with a candidate effect whose size is the detection limit of this recording.
Rival just_visible(const fit::Fit& answer, const CandidateView& view, const DetectionLimit& limit) {
    Rival rival{answer, limit.effect};
    rival.fit.effects.push_back(view.effect);
    fit::FittedParameter size;
    size.id = {limit.effect, limit.parameter, {}};
    size.value = limit.value;
    rival.fit.parameters.push_back(std::move(size));
    return rival;
}

/// The answer and the model it is most easily confused with. Without such rivals: the answer
/// and the undetected effect that would bias it most.
std::optional<std::pair<Rival, Rival>> pair_to_separate(const SearchResult& search,
                                                        const Diagnosis& out) {
    const std::size_t answer = out.alternatives.front().model;
    const Rival own{search.visited[answer].fit, {}};
    if (out.alternatives.size() > 1 && out.alternatives[1].model != answer)
        return std::pair(own, Rival{search.visited[out.alternatives[1].model].fit, {}});
    if (out.conclusion == Conclusion::Unknown || answer != search.best)
        return std::nullopt;
    const auto harm = [](const DetectionLimit& limit) {
        return std::max(std::abs(limit.youngs_modulus_bias), std::abs(limit.damping_bias));
    };
    std::optional<std::size_t> worst;
    for (std::size_t k = 0; k < out.blind_spots.size(); ++k) {
        const DetectionLimit& limit = out.blind_spots[k];
        // No change of the experiment reveals an effect out of the plane.
        if (limit.failure.empty() && !limit.is_beyond_bounds && !limit.parameter.empty() &&
            search.views[k].effect.effect->dimensions() < 3 &&
            (!worst || harm(limit) > harm(out.blind_spots[*worst])))
            worst = k;
    }
    if (!worst)
        return std::nullopt;
    return std::pair(just_visible(own.fit, search.views[*worst], out.blind_spots[*worst]), own);
}

} // namespace

std::string_view to_string(Conclusion conclusion) {
    constexpr std::array names{"adequate", "effect", "tie", "unknown"};
    return names[static_cast<std::size_t>(conclusion)];
}

Diagnosis decide(SearchResult& search, const DiagnosisOptions& options) {
    Diagnosis out;
    out.policy = options.policy;
    out.posterior = posterior_of(search, options);
    out.batches = search.batches;
    out.is_complete = search.is_complete;
    add_alternatives(search, options, out);
    climb_to(search, options, out.alternatives.front().model, out);
    add_residual(out);
    conclude(search, options, out);
    if (!search.unvisited.empty()) {
        const UnvisitedModel& model = search.unvisited.front();
        out.largest_unvisited = {names_of(model.effects, options),
                                 model.log_evidence - search.visited[search.best].log_evidence};
    }
    out.baseline = std::move(search.chain.fit);
    return out;
}

Diagnosis diagnose(std::span<const measure::Measurement> recordings, DiagnosisOptions options) {
    if (options.candidates.empty())
        options.candidates = fit::candidate_effects(recordings);
    options.candidates = fit::in_library_order(std::move(options.candidates));
    std::erase_if(options.candidates,
                  [&](const auto& each) { return fit::contains(options.known, each); });
    for (const measure::Measurement& recording : recordings)
        refuse_without_motion(recording, options.candidate.window);
    DiagnosisOptions coarse = options;
    coarse.candidate.chain.spheres = fit::coarsest_chain(recordings, options.candidate);
    SearchResult search = search_models(recordings, coarse);
    SearchResult final = with_stated_chain(search, recordings, coarse, options);
    if (key_of(final.best_fit.effects) != key_of(search.best_fit.effects)) {
        // The coarse chain led to another model.
        coarse = options;
        search = search_models(recordings, options);
        final = search;
    }
    Diagnosis out = decide(final, options);
    out.blind_spots = detection_limits(search);
    if (const std::optional<std::pair<Rival, Rival>> pair = pair_to_separate(search, out)) {
        options.report("computing which experiment distinguishes best");
        try {
            out.next_experiments =
                next_experiments(*pair, search.chain.recordings, coarse.candidate, options.map);
        } catch (const core::NumericalError&) {
            // A rival that cannot be computed again leaves the answer without a proposal.
        }
    }
    if (out.conclusion == Conclusion::Unknown && out.ladder.back().finding == Finding::Inadequate) {
        options.report("reconstructing the missing force");
        // A partial explanation may be the wrong effect, so the force replaces all effects.
        out.missing_force = reconstruct_missing_force(fit_of(search, 0, coarse), options.known,
                                                      search.chain.recordings, coarse.candidate);
    }
    return out;
}

} // namespace culm::diagnose
