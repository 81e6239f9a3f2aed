// SPDX-License-Identifier: BSD-3-Clause
#include "diagnose/diagnosis.hpp"

#include "diagnose/planned_model.hpp"
#include "fit/fit_numbers.hpp"

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

fit::Fit restored(const SearchResult& search, std::size_t model, const DiagnosisOptions& options) {
    return model == search.best
               ? search.best_fit
               : fit::restored(search.visited[model].fit, search.recordings, options.candidate);
}

/// The sets of families that hold 95 % of the probability, and the families common to all.
void add_alternatives(const Policy& policy, Diagnosis& out) {
    double held = 0.0;
    for (const FamilyExplanation& entry : out.posterior.by_family) {
        if (held >= policy.held_probability)
            break;
        held += entry.probability;
        out.alternatives.push_back(entry);
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
    added.fit = restored(search, model, options);
    const bool is_best = model == search.best;
    added.stated = is_best ? search.stated_best
                           : fit::as_stated(added.fit, search.stated_baseline, search.recordings,
                                            options.candidate);
    if (!added.stated.failed() && !absent_effects(added.stated, options.known).empty()) {
        added.stated = added.fit;
        added.has_free_inputs = true;
    }
    const SetVerdict verdict = verdict_on(added.fit, search.recordings, options.policy);
    added.finding = verdict.finding;
    added.p_value = verdict.p_value;
    added.tests = verdict.reason;
    added.log_evidence = search.visited[model].log_evidence - search.visited.front().log_evidence;
}

/// Steps from the published chain to the answer, via the best model with one of its effects.
void climb_to(const SearchResult& search, const DiagnosisOptions& options, std::size_t answer,
              Diagnosis& out) {
    add_model(search, options, 0, out);
    const fit::SelectedEffects& effects = search.visited[answer].fit.effects;
    if (effects.size() > options.known.size() + 1) {
        std::optional<std::size_t> between;
        for (std::size_t k = 1; k < search.visited.size(); ++k) {
            const fit::SelectedEffects& own = search.visited[k].fit.effects;
            const bool is_part =
                own.size() == options.known.size() + 1 && contains_all(effects, own);
            if (is_part && (!between ||
                            search.visited[k].log_evidence > search.visited[*between].log_evidence))
                between = k;
        }
        if (between && std::isfinite(search.visited[*between].log_evidence))
            add_model(search, options, *between, out);
    }
    if (answer != 0)
        add_model(search, options, answer, out);
    out.final_fit = out.ladder.back().fit;
}

void add_residual(Diagnosis& out) {
    out.explained = explained_share(out.final_fit, out.ladder.front().fit);
    const fit::Fit& shown =
        out.ladder.back().stated.failed() ? out.final_fit : out.ladder.back().stated;
    double squares = 0.0;
    double noise = 0.0;
    double swing = 0.0;
    double readings = 0.0;
    for (const fit::RecordingFit& part : shown.parts)
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
    if (leaves_too_much(last.fit, out.ladder.front().fit, search.recordings, options.policy)) {
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
    rival.fit.names = fit::model_names(fit::in_library_order(rival.fit.effects));
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
    out.posterior = posterior_of(search, options,
                                 has_structure(search.best_fit, search.recordings, options.policy));
    out.runs = search.runs;
    add_alternatives(options.policy, out);
    climb_to(search, options, out.alternatives.front().model, out);
    add_residual(out);
    conclude(search, options, out);
    if (!search.unvisited.empty()) {
        const UnvisitedModel& model = search.unvisited.front();
        out.largest_unvisited = {names_of(model.effects, options),
                                 model.log_evidence - search.visited[search.best].log_evidence};
    }
    out.baseline = std::move(search.baseline);
    out.stated_baseline = std::move(search.stated_baseline);
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
    SearchResult search = search_models(recordings, options);
    Diagnosis out = decide(search, options);
    options.report("computing the detection limits of the other effects");
    out.blind_spots = detection_limits(search, options);
    if (const std::optional<std::pair<Rival, Rival>> pair = pair_to_separate(search, out)) {
        options.report("computing which experiment distinguishes best");
        out.next_experiments =
            next_experiments(*pair, search.recordings, options.candidate, options.map);
    }
    if (out.conclusion == Conclusion::Unknown && out.ladder.back().finding == Finding::Inadequate) {
        options.report("reconstructing the missing force");
        // A partial explanation may be the wrong effect, so the force replaces all effects.
        out.missing_force = reconstruct_missing_force(restored(search, 0, options), options.known,
                                                      search.recordings, options.candidate);
    }
    return out;
}

} // namespace culm::diagnose
