// SPDX-License-Identifier: BSD-3-Clause
#include "diagnose/diagnosis.hpp"

#include "core/error.hpp"
#include "fit/fit_numbers.hpp"
#include "fit/start/starts.hpp"
#include "physics/effects/library.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <utility>

#include <fmt/format.h>

namespace culm::diagnose {
namespace {

/// Was the model fitted with every other law of the library of the effect's family instead of it,
/// and does each fail the tests for lack of fit?
bool is_only_law(const SearchResult& search, std::size_t model, const OwnedEffect& name) {
    const std::vector<ActingEffect>& effects = search.visited[model].effects;
    const auto own = std::ranges::find(effects, name, owned);
    if (own == effects.end())
        return false;
    const auto is_inadequate = [](const StemFit& stem) {
        return stem.verdict.finding == Finding::Inadequate;
    };
    return std::ranges::all_of(physics::all_effects(), [&](const physics::EffectPointer& other) {
        if (other->name == name.first || other->family != own->effect.effect->family)
            return true;
        std::vector<ActingEffect> swapped = effects;
        swapped[static_cast<std::size_t>(own - effects.begin())].effect =
            physics::parse_effect(other->name, {});
        const Model* const found = find_model(search.visited, swapped);
        return found != nullptr && std::ranges::any_of(found->stems, is_inadequate);
    });
}

/// The sets of families that hold 95 % of the probability, and the families common to all.
void add_alternatives(const SearchResult& search, Diagnosis& out) {
    const DiagnosisOptions& options = search.stems->options();
    double held = 0.0;
    for (const FamilyExplanation& entry : out.posterior.by_family) {
        if (held >= options.policy.held_probability)
            break;
        held += entry.probability;
        FamilyExplanation& added = out.alternatives.emplace_back(entry);
        for (NamedFamily& named : added.families)
            named.is_open = physics::is_one_law(named.family) &&
                            !(named.members.size() == 1 &&
                              is_only_law(search, entry.model, {named.members.front(), named.rig}));
    }
    out.families = out.alternatives.front().families;
    for (const FamilyExplanation& other : out.alternatives)
        std::erase_if(out.families, [&](const NamedFamily& named) {
            return std::ranges::none_of(
                other.families, [&](const NamedFamily& each) { return each.is_same_as(named); });
        });
}

void add_model(const SearchResult& search, std::size_t model, Diagnosis& out) {
    out.ladder.push_back(
        {search.rerun(model, 0), search.visited[model].stems[0].verdict,
         search.visited[model].log_evidence - search.visited.front().log_evidence});
}

/// Steps from the published chain to the answer, via the best model with one of its effects.
void climb_to(const SearchResult& search, std::size_t answer, Diagnosis& out) {
    add_model(search, 0, out);
    if (const auto part = likeliest_part(search.visited, answer))
        add_model(search, *part, out);
    if (answer != 0)
        add_model(search, answer, out);
    out.baseline = out.ladder.front().fit;
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

std::string why_unknown(const Stems& stems, const Model& answer, const Diagnosis& out) {
    if (stems.is_one()) {
        const std::string& tests = answer.stems[0].verdict.reason;
        return fmt::format(
            "the best model fails the tests for lack of fit{} and leaves {:.0f} % of the misfit",
            tests.empty() ? "" : fmt::format(" ({})", tests), 100.0 * (1.0 - out.explained));
    }
    return "the residuals of more than half of the stems have structure that no model explains";
}

void conclude(const SearchResult& search, Diagnosis& out) {
    const Stems& stems = *search.stems;
    const Model& answer = search.visited[out.alternatives.front().model];
    const auto is_chain = [](const FamilyExplanation& each) { return each.families.empty(); };
    const auto chain = std::ranges::find_if(out.alternatives, is_chain);
    // An effect that the readings of several stems do not exclude biases all of them.
    const bool chain_is_likely =
        chain != out.alternatives.end() && (stems.is_one() || out.alternatives.size() == 1);
    const SetVerdict& of_chain = search.visited.front().stems[0].verdict;
    if (most_leave_too_much(stems, answer, search.visited.front())) {
        out.conclusion = Conclusion::Unknown;
        out.reason = why_unknown(stems, answer, out);
    } else if (chain_is_likely && stems.is_one() && of_chain.finding == Finding::Undecided) {
        out.conclusion = Conclusion::Unknown;
        out.reason = of_chain.reason;
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
        for (const auto& [effect, rig] : added_names(answer.effects))
            out.effects.push_back(effect);
    else
        out.families.clear();
    out.probability = out.alternatives.front().probability;
    if (out.conclusion == Conclusion::Adequate)
        out.probability = chain->probability;
}

/// A model with a candidate effect whose size is the detection limit of this recording.
Rival just_visible(const fit::Fit& answer, const physics::SelectedEffect& effect,
                   const DetectionLimit& limit) {
    Rival rival{answer, limit.effect};
    rival.fit.effects.push_back(effect);
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
    const Rival own{search.visited[answer].stems[0].fit, {}};
    if (out.alternatives.size() > 1 && out.alternatives[1].model != answer)
        return std::pair(own, Rival{search.visited[out.alternatives[1].model].stems[0].fit, {}});
    if (out.conclusion == Conclusion::Unknown || answer != search.best)
        return std::nullopt;
    const auto harm = [](const DetectionLimit& limit) {
        return std::max(std::abs(limit.youngs_modulus_bias), std::abs(limit.damping_bias));
    };
    const DetectionLimit* worst = nullptr;
    const physics::SelectedEffect* effect = nullptr;
    for (const DetectionLimit& limit : out.detection_limits)
        for (const physics::SelectedEffect& candidate : search.stems->options().candidates)
            // No change of the experiment reveals an effect out of the plane.
            if (candidate.effect->name == limit.effect && limit.failure.empty() &&
                !limit.is_beyond_bounds && !limit.parameter.empty() &&
                candidate.effect->dimensions < 3 &&
                (worst == nullptr || harm(limit) > harm(*worst))) {
                worst = &limit;
                effect = &candidate;
            }
    if (worst == nullptr)
        return std::nullopt;
    return std::pair(just_visible(own.fit, *effect, *worst), own);
}

/// The smallest number of spheres that suffices for the search, for all stems. Throws
/// core::InputError if the only stem cannot be a chain; of several, such a stem is left out later.
int spheres_of_search(std::span<const Specimen> specimens, const DiagnosisOptions& options) {
    using Answer = std::pair<int, std::string>; // and why there is none
    const std::vector<double> costs(specimens.size(), 1.0);
    const std::vector<Answer> answers =
        options.map.values(costs, [&](std::size_t s, const run::Heartbeat& heartbeat) -> Answer {
            try {
                return {fit::coarsest_chain(specimens[s].recordings,
                                            fit::with_heartbeat(options.candidate, heartbeat)),
                        {}};
            } catch (const core::InputError& error) {
                return {0, error.what()};
            }
        });
    if (answers.size() == 1 && !answers.front().second.empty())
        throw core::InputError(answers.front().second);
    return std::ranges::max(answers, {}, &Answer::first).first;
}

/// Adds the parts of a diagnosis that only one stem has.
void add_details(const SearchResult& search, Diagnosis& out) {
    const DiagnosisOptions& options = search.stems->options();
    const ObservedStem& stem = (*search.stems)[0];
    if (const std::optional<std::pair<Rival, Rival>> pair = pair_to_separate(search, out)) {
        options.report("computing which experiment distinguishes best");
        try {
            out.next_experiments =
                next_experiments(*pair, stem.recordings, options.candidate, options.map);
        } catch (const core::NumericalError&) {
            // A rival that cannot be computed again leaves the answer without a proposal.
        }
    }
    if (out.conclusion == Conclusion::Unknown &&
        out.ladder.back().verdict.finding == Finding::Inadequate) {
        options.report("reconstructing the missing force");
        // A partial explanation may be the wrong effect, so the force replaces all effects.
        out.missing_force = reconstruct_missing_force(search.rerun(0, 0), options.known,
                                                      stem.recordings, options.candidate);
    }
}

} // namespace

std::string_view to_string(Conclusion conclusion) {
    constexpr std::array names{"adequate", "effect", "tie", "unknown"};
    return names[static_cast<std::size_t>(conclusion)];
}

Diagnosis decide(const SearchResult& search) {
    const Stems& stems = *search.stems;
    Diagnosis out;
    out.policy = stems.options().policy;
    out.posterior = posterior_of(search);
    out.batches = search.batches;
    out.is_complete = search.is_complete;
    add_alternatives(search, out);
    if (stems.is_one()) {
        climb_to(search, out.alternatives.front().model, out);
        add_residual(out);
        const std::vector<measure::Measurement>& recordings = stems.specimen(0).recordings;
        for (std::size_t m = 0; m < recordings.size(); ++m)
            out.comparisons.push_back(compare(out.final_fit, m, recordings[m], out.policy));
    }
    conclude(search, out);
    const std::size_t answer =
        out.conclusion == Conclusion::Adequate ? 0 : out.alternatives.front().model;
    out.answers = effect_answers(search, out.posterior, answer);
    out.stems = stem_answers(search, answer);
    out.before = population_of(out.stems, &StemAnswer::before);
    out.after = population_of(out.stems, &StemAnswer::after);
    if (!search.unvisited.empty()) {
        out.largest_unvisited = search.unvisited.front();
        out.largest_unvisited->log_evidence -= search.best_model().log_evidence;
    }
    return out;
}

Diagnosis diagnose(std::span<const Specimen> specimens, DiagnosisOptions options) {
    std::vector<measure::Measurement> recordings;
    for (const Specimen& specimen : specimens)
        std::ranges::copy(specimen.recordings, std::back_inserter(recordings));
    if (options.candidates.empty())
        options.candidates = fit::candidate_effects(recordings);
    options.candidates = fit::in_library_order(std::move(options.candidates));
    std::erase_if(options.candidates,
                  [&](const auto& each) { return fit::contains(options.known, each); });
    for (const measure::Measurement& recording : recordings)
        if (specimens.size() == 1)
            refuse_without_motion(recording, options.candidate.window);
    DiagnosisOptions coarse = options;
    if (const int spheres = spheres_of_search(specimens, options); spheres > 0)
        coarse.candidate.chain.spheres = spheres;
    const bool is_coarse = std::ranges::any_of(recordings, [&](const auto& recording) {
        return fit::chain_of(recording, options.candidate.chain).spec.stem.sphere_count !=
               fit::chain_of(recording, coarse.candidate.chain).spec.stem.sphere_count;
    });
    const SearchResult search = search_models(specimens, coarse);
    const auto answer_of = [&](const SearchResult& models, const SearchResult& about) {
        Diagnosis out = decide(models);
        out.detection_limits = detection_limits(about);
        if (specimens.size() == 1)
            add_details(about, out);
        return out;
    };
    if (!is_coarse)
        return answer_of(search, search);
    const SearchResult final = with_stated_chain(search, options);
    if (key_of(final.best_model().effects) == key_of(search.best_model().effects))
        return answer_of(final, search);
    // The coarse chain led to another model.
    const SearchResult again = search_models(specimens, options);
    return answer_of(again, again);
}

} // namespace culm::diagnose
