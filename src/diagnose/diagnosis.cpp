// SPDX-License-Identifier: BSD-3-Clause
#include "diagnose/diagnosis.hpp"

#include "fit/fit_numbers.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

namespace culm::diagnose {
namespace {

class Answer {
  public:
    Answer(SearchResult search, const DiagnosisOptions& options)
        : search_(std::move(search)), options_(options), policy_(options.policy) {
        out_.policy = policy_;
        out_.posterior =
            posterior_of(search_, options,
                         has_structure(search_.best_fit, search_.recordings, policy_), policy_);
        out_.runs = search_.runs;
    }

    void decide() {
        add_alternatives();
        climb_to(out_.alternatives.front().model);
        add_residual();
        conclude();
        if (!search_.unvisited.empty()) {
            const UnvisitedModel& model = search_.unvisited.front();
            out_.largest_unvisited = {names_of(model.effects),
                                      model.log_evidence -
                                          search_.visited[search_.best].log_evidence};
        }
    }

    /// Adds the results that follow from the verdict.
    void complete() {
        const std::size_t answer = out_.alternatives.front().model;
        report("computing the detection limits of the other effects");
        out_.blind_spots = detection_limits(search_, options_);
        add_experiments(answer);
        if (out_.conclusion == Conclusion::Unknown &&
            out_.ladder.back().finding == Finding::Inadequate) {
            report("reconstructing the missing force");
            // A partial explanation may be the wrong effect, so the force replaces all effects.
            out_.missing_force = reconstruct_missing_force(restored(0), options_.known,
                                                           search_.recordings, options_.candidate);
        }
    }

    [[nodiscard]] Diagnosis take() {
        out_.baseline = std::move(search_.baseline);
        out_.stated_baseline = std::move(search_.stated_baseline);
        return std::move(out_);
    }

  private:
    void report(const std::string& next) const {
        if (options_.progress)
            options_.progress(next);
    }

    [[nodiscard]] std::vector<std::string> names_of(const fit::SelectedEffects& effects) const {
        std::vector<std::string> names;
        for (std::size_t k = options_.known.size(); k < effects.size(); ++k)
            names.push_back(effects[k].effect->name());
        return names;
    }

    [[nodiscard]] fit::Fit restored(std::size_t model) const {
        return model == search_.best ? search_.best_fit
                                     : fit::restored(search_.visited[model].fit, search_.recordings,
                                                     options_.candidate);
    }

    /// The sets of families that hold 95 % of the probability, and the families common to all.
    void add_alternatives() {
        double held = 0.0;
        for (const FamilyExplanation& entry : out_.posterior.by_family) {
            if (held >= policy_.held_probability)
                break;
            held += entry.probability;
            out_.alternatives.push_back(entry);
        }
        out_.families = out_.alternatives.front().families;
        for (const FamilyExplanation& other : out_.alternatives)
            std::erase_if(out_.families, [&](const NamedFamily& named) {
                return std::ranges::find(other.families, named.family, &NamedFamily::family) ==
                       other.families.end();
            });
    }

    void add_model(std::size_t model) {
        SearchedModel& added = out_.ladder.emplace_back();
        added.fit = restored(model);
        const bool is_best = model == search_.best;
        added.stated = is_best ? search_.stated_best
                               : fit::as_stated(added.fit, search_.stated_baseline,
                                                search_.recordings, options_.candidate);
        if (!added.stated.failed() && !absent_effects(added.stated, options_.known).empty()) {
            added.stated = added.fit;
            added.has_free_inputs = true;
        }
        const SetVerdict verdict = verdict_on(added.fit, search_.recordings, policy_);
        added.finding = verdict.finding;
        added.p_value = verdict.p_value;
        added.tests = verdict.reason;
        added.log_evidence =
            search_.visited[model].log_evidence - search_.visited.front().log_evidence;
    }

    /// Steps from the published chain to the answer, via the best model with one of its effects.
    void climb_to(std::size_t answer) {
        add_model(0);
        const fit::SelectedEffects& effects = search_.visited[answer].fit.effects;
        if (effects.size() > options_.known.size() + 1) {
            std::optional<std::size_t> between;
            for (std::size_t k = 1; k < search_.visited.size(); ++k) {
                const fit::SelectedEffects& own = search_.visited[k].fit.effects;
                const bool is_part = own.size() == options_.known.size() + 1 &&
                                     std::ranges::all_of(own, [&](const auto& each) {
                                         return fit::contains(effects, each);
                                     });
                if (is_part && (!between || search_.visited[k].log_evidence >
                                                search_.visited[*between].log_evidence))
                    between = k;
            }
            if (between && std::isfinite(search_.visited[*between].log_evidence))
                add_model(*between);
        }
        if (answer != 0)
            add_model(answer);
        out_.final_fit = out_.ladder.back().fit;
    }

    void add_residual() {
        out_.explained = explained_share(out_.final_fit, out_.ladder.front().fit);
        const fit::Fit& shown =
            out_.ladder.back().stated.failed() ? out_.final_fit : out_.ladder.back().stated;
        double squares = 0.0;
        double noise = 0.0;
        double swing = 0.0;
        double readings = 0.0;
        for (std::size_t m = 0; m < shown.parts.size(); ++m) {
            const fit::RecordingFit& part = shown.parts[m];
            for (std::size_t k = 0; k < part.residuals.size(); ++k) {
                const double measured = part.residuals[k] + part.prediction.readings[k];
                if (!std::isfinite(measured))
                    continue;
                squares += part.residuals[k] * part.residuals[k];
                noise +=
                    part.is_noise_known ? std::pow(part.noise[k % part.prediction.rows], 2) : 0.0;
                swing += measured * measured;
                readings += 1.0;
            }
        }
        out_.unexplained = std::sqrt(std::max(0.0, squares - noise) / std::max(readings, 1.0));
        out_.unexplained_share =
            swing > 0.0 ? out_.unexplained / std::sqrt(swing / std::max(readings, 1.0)) : 0.0;
    }

    void conclude() {
        const bool chain_is_likely = std::ranges::any_of(
            out_.alternatives, [](const FamilyExplanation& each) { return each.families.empty(); });
        const SearchedModel& last = out_.ladder.back();
        if (leaves_too_much(last.fit, out_.ladder.front().fit, search_.recordings, policy_)) {
            out_.conclusion = Conclusion::Unknown;
            out_.reason = fmt::format(
                "{} and leaves {:.0f} % of the misfit",
                last.tests.empty() ? "the best model fails the tests for lack of fit"
                                   : fmt::format("the best model fails the tests for lack of fit "
                                                 "({})",
                                                 last.tests),
                100.0 * (1.0 - out_.explained));
        } else if (chain_is_likely && out_.ladder.front().finding == Finding::Undecided) {
            out_.conclusion = Conclusion::Unknown;
            out_.reason = out_.ladder.front().tests;
        } else if (chain_is_likely) {
            out_.conclusion = Conclusion::Adequate;
            out_.reason = "no other explanation is needed for 95 % of the probability";
        } else {
            out_.conclusion = out_.alternatives.size() == 1 ? Conclusion::Effect : Conclusion::Tie;
            out_.reason = out_.conclusion == Conclusion::Effect
                              ? "these effects hold 95 % of the probability"
                              : fmt::format("{} explanations are needed for 95 % of the "
                                            "probability",
                                            out_.alternatives.size());
        }
        add_named();
    }

    void add_named() {
        const FamilyExplanation& first = out_.alternatives.front();
        if (out_.conclusion == Conclusion::Adequate) {
            for (const FamilyExplanation& each : out_.alternatives)
                if (each.families.empty())
                    out_.probability = each.probability;
            out_.families.clear();
            return;
        }
        out_.probability = first.probability;
        if (out_.conclusion == Conclusion::Unknown)
            out_.families.clear();
        else
            out_.effects = names_of(search_.visited[first.model].fit.effects);
    }

    // --- The next experiment

    /// A model with a candidate effect whose size is the detection limit of this recording.
    [[nodiscard]] Rival just_visible(const fit::Fit& answer, const CandidateView& view,
                                     const DetectionLimit& limit) const {
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
    [[nodiscard]] std::optional<std::pair<Rival, Rival>>
    pair_to_separate(std::size_t answer) const {
        const Rival own{search_.visited[answer].fit, {}};
        if (out_.alternatives.size() > 1 && out_.alternatives[1].model != answer)
            return std::pair(own, Rival{search_.visited[out_.alternatives[1].model].fit, {}});
        if (out_.conclusion == Conclusion::Unknown || answer != search_.best)
            return std::nullopt;
        const auto harm = [](const DetectionLimit& limit) {
            return std::max(std::abs(limit.youngs_modulus_bias), std::abs(limit.damping_bias));
        };
        std::optional<std::size_t> worst;
        for (std::size_t k = 0; k < out_.blind_spots.size(); ++k) {
            const DetectionLimit& limit = out_.blind_spots[k];
            // No change of the experiment reveals an effect out of the plane.
            if (limit.failure.empty() && !limit.is_beyond_bounds && !limit.parameter.empty() &&
                search_.views[k].effect.effect->dimensions() < 3 &&
                (!worst || harm(limit) > harm(out_.blind_spots[*worst])))
                worst = k;
        }
        if (!worst)
            return std::nullopt;
        return std::pair(just_visible(own.fit, search_.views[*worst], out_.blind_spots[*worst]),
                         own);
    }

    void add_experiments(std::size_t answer) {
        const std::optional<std::pair<Rival, Rival>> pair = pair_to_separate(answer);
        if (!pair)
            return;
        report("computing which experiment distinguishes best");
        out_.next_experiments =
            next_experiments(*pair, search_.recordings, options_.candidate, options_.map);
    }

    SearchResult search_;
    const DiagnosisOptions& options_;
    const Policy& policy_;
    Diagnosis out_;
};

} // namespace

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

Diagnosis decide(SearchResult search, const DiagnosisOptions& options) {
    Answer answer(std::move(search), options);
    answer.decide();
    return answer.take();
}

Diagnosis diagnose(std::span<const measure::Measurement> recordings, DiagnosisOptions options) {
    if (options.candidates.empty())
        options.candidates = fit::candidate_effects(recordings);
    options.candidates = fit::in_library_order(std::move(options.candidates));
    std::erase_if(options.candidates,
                  [&](const auto& each) { return fit::contains(options.known, each); });
    for (const measure::Measurement& recording : recordings)
        refuse_without_motion(recording, options.candidate.window);
    Answer answer(search_models(recordings, options, options.policy), options);
    answer.decide();
    answer.complete();
    return answer.take();
}

} // namespace culm::diagnose
