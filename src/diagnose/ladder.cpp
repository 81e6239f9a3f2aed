// SPDX-License-Identifier: BSD-3-Clause
#include "diagnose/ladder.hpp"

#include "diagnose/adequacy.hpp"
#include "diagnose/judge.hpp"

#include <algorithm>
#include <utility>

namespace culm::diagnose {
namespace {

std::vector<std::string> difference(const std::vector<std::string>& larger,
                                    const std::vector<std::string>& smaller) {
    std::vector<std::string> added;
    for (const std::string& name : larger)
        if (std::ranges::find(smaller, name) == smaller.end())
            added.push_back(name);
    return added;
}

/// Of the chain with the inputs as stated: an inadequate model pulls these far from where they were
/// measured, and Y after them.
double relative_change(const fit::RecordingFit& now, const fit::RecordingFit& before,
                       double physics::StemParameters<double>::*member) {
    return fit::case_beside_errors(now.model).stem.*member /
               fit::case_beside_errors(before.model).stem.*member -
           1.0;
}

/// The fitted models with their effective readings.
std::vector<fit::Fit> numbers_of(const Ladder& ladder) {
    std::vector<fit::Fit> numbers;
    for (const LadderModel& model : ladder.models)
        numbers.push_back(fit::numbers_of(model.fit));
    return numbers;
}

/// The model with the smallest residual, which is closest to the noise.
const fit::Fit* best_fit(const Ladder& ladder) {
    const fit::Fit* best = nullptr;
    for (const LadderModel& model : ladder.models)
        if (!model.fit.failed() && (best == nullptr || model.fit.rmse < best->rmse))
            best = &model.fit;
    return best;
}

HoldOut what_to_hold_out(const Ladder& ladder, const Policy& policy) {
    const fit::Fit* const best = best_fit(ladder);
    return best == nullptr ? HoldOut{}
                           : hold_out_of(ladder.left_out_row, best->parts.front(), policy);
}

/// What model `k` is worth against `accepted`, the last that was a gain, and `below`, the last that
/// was fitted. What was refused already is not asked for its size again.
void judge_model(Ladder& ladder, std::size_t k, std::size_t accepted, std::size_t below,
                 const std::vector<fit::Fit>& numbers, const Criterion& criterion,
                 std::size_t tried, const Policy& policy) {
    LadderModel& model = ladder.models[k];
    const LadderModel& before = ladder.models[accepted];
    model.compared_with = accepted;
    model.added = difference(model.fit.names, before.fit.names);
    std::optional<HeldOutPair> held_out;
    if (model.held_out && before.held_out)
        held_out = {*model.held_out, *before.held_out};
    const Judgement judgement =
        judge({.smaller = numbers[accepted],
               .larger = numbers[k],
               .criterion = criterion,
               .added = difference(model.fit.names, ladder.models[below].fit.names),
               .tried = tried,
               .refused = below == accepted ? nullptr : &numbers[below],
               .held_out = std::move(held_out)},
              policy);
    model.is_gain = judgement.is_accepted();
    model.why = in_words(judgement, policy);
    if (model.fit.failed())
        return;
    model.delta_bic = -judgement.gain;
    if (before.fit.moves()) {
        const fit::RecordingFit& fit = model.fit.parts.front();
        const fit::RecordingFit& smaller = before.fit.parts.front();
        model.modulus_change =
            relative_change(fit, smaller, &physics::StemParameters<double>::bond_youngs_modulus);
        model.damping_change =
            relative_change(fit, smaller, &physics::StemParameters<double>::bond_damping);
    }
}

void judge_models(Ladder& ladder, std::size_t tried, const Policy& policy) {
    const std::vector<fit::Fit> numbers = numbers_of(ladder);
    const Criterion by = criterion(numbers);
    ladder.effective_readings = by.effective_readings;
    for (std::size_t k = 0; k < ladder.models.size(); ++k)
        if (!ladder.models[k].fit.failed())
            ladder.models[k].bic = bic(numbers[k], by);
    std::size_t accepted = 0;
    std::size_t below = 0;
    for (std::size_t k = 1; k < ladder.models.size(); ++k) {
        judge_model(ladder, k, accepted, below, numbers, by, tried, policy);
        if (!ladder.models[k].fit.failed())
            below = k;
        if (ladder.models[k].is_gain)
            accepted = k;
    }
}

bool contains(const std::vector<std::string>& larger, const std::vector<std::string>& smaller) {
    return difference(smaller, larger).empty();
}

/// The largest fitted model within `names`; the baseline if there is none.
const fit::Fit& model_within(const std::vector<std::string>& names, const Ladder& ladder) {
    const fit::Fit* within = &ladder.models.front().fit;
    for (const LadderModel& model : ladder.models)
        if (!model.fit.failed() && contains(names, model.fit.names))
            within = &model.fit;
    return *within;
}

/// Throws what a model that cannot be throws, before any chain is run.
void refuse_impossible(const std::vector<fit::SelectedEffects>& effect_sets,
                       const measure::Measurement& measurement, const fit::FitOptions& options) {
    const fit::StemModel baseline = fit::baseline_model(measurement, options.chain);
    for (const fit::SelectedEffects& effects : effect_sets)
        (void)fit::candidate_model(baseline, effects, measurement);
}

} // namespace

namespace {

/// The baseline and each set of effects, fitted from the largest model within it.
Ladder fitted(fit::Fit baseline, std::span<const measure::Measurement> alone,
              const std::vector<fit::SelectedEffects>& effect_sets,
              const fit::FitOptions& options) {
    Ladder ladder;
    ladder.models.emplace_back().fit = std::move(baseline);
    for (const fit::SelectedEffects& effects : effect_sets) {
        LadderModel model;
        model.fit = fit::fit_with_parts(effects, model_within(fit::model_names(effects), ladder),
                                        alone, options);
        ladder.models.push_back(std::move(model));
    }
    return ladder;
}

} // namespace

Ladder climb(const measure::Measurement& measurement,
             const std::vector<fit::SelectedEffects>& effect_sets, const fit::FitOptions& options,
             const Policy& policy) {
    refuse_without_motion(measurement, options.window, policy);
    refuse_impossible(effect_sets, measurement, options);
    fit::BaselineFit baseline = fit::fit_baseline({&measurement, 1}, options);
    Ladder ladder = fitted(baseline.fit, baseline.recordings, effect_sets, options);
    // As diagnose() does: what the chain lacks may have passed for noise.
    if (const fit::Fit* best = best_fit(ladder); best != nullptr && best->names.size() > 1)
        if (auto again =
                fit::baseline_beside_noise_of(*best, baseline, {&measurement, 1}, options)) {
            baseline = std::move(*again);
            ladder = fitted(baseline.fit, baseline.recordings, effect_sets, options);
        }
    const std::span<const measure::Measurement> alone(baseline.recordings);
    if (!ladder.models.front().fit.failed())
        ladder.left_out_row = row_to_leave_out(ladder.models.front().fit.parts.front());
    const HoldOut hold_out = what_to_hold_out(ladder, policy);
    for (LadderModel& model : ladder.models) {
        ladder.comparison.emplace_back();
        if (model.fit.failed())
            continue;
        model.held_out = predict_held_out(model.fit, hold_out, alone.front(), options);
        ladder.comparison.back() = ladder.comparisons.size();
        ladder.comparisons.push_back(compare(model.fit, measurement));
    }
    // By as many candidates as diagnose() has: a model is not accepted here and refused there.
    judge_models(ladder, fit::candidate_effects(alone).size(), policy);
    return ladder;
}

} // namespace culm::diagnose
