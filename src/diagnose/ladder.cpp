// SPDX-License-Identifier: BSD-3-Clause
#include "diagnose/ladder.hpp"

#include "diagnose/adequacy.hpp"
#include "diagnose/judge.hpp"
#include "fit/solve/reading_errors.hpp"

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

double relative_change(const fit::Fit& now, const fit::Fit& before,
                       double physics::StemParameters<double>::*member) {
    return now.parts.front().model.spec.stem.*member /
               before.parts.front().model.spec.stem.*member -
           1.0;
}

/// The fitted models with their effective readings.
std::vector<fit::Fit> numbers_of(const Ladder& ladder) {
    std::vector<fit::Fit> numbers;
    for (const LadderModel& model : ladder.models)
        numbers.push_back(fit::numbers_of(model.fit));
    return numbers;
}

/// The model whose residual is closest to the noise.
const fit::Fit* best_fit(const Ladder& ladder) {
    const fit::Fit* best = nullptr;
    for (const LadderModel& model : ladder.models)
        if (!model.fit.failed() &&
            (best == nullptr || model.stated.weighted_rms < best->weighted_rms))
            best = &model.stated;
    return best;
}

HoldOut what_to_hold_out(const Ladder& ladder) {
    const fit::Fit* const best = best_fit(ladder);
    return best == nullptr ? HoldOut{} : HoldOut{ladder.left_out_row, best->parts.front().noise};
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
    const Judgement judgement =
        judge({.smaller = numbers[accepted],
               .larger = numbers[k],
               .criterion = criterion,
               .added = difference(model.fit.names, ladder.models[below].fit.names),
               .tried = tried,
               .refused = below == accepted ? nullptr : &numbers[below]},
              policy);
    model.is_gain = judgement.is_accepted();
    model.why = in_words(judgement, policy);
    if (model.fit.failed())
        return;
    model.delta_bic = -judgement.gain;
    if (before.fit.moves()) {
        model.modulus_change = relative_change(
            model.stated, before.stated, &physics::StemParameters<double>::bond_youngs_modulus);
        model.damping_change = relative_change(model.stated, before.stated,
                                               &physics::StemParameters<double>::bond_damping);
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

} // namespace

Ladder climb(const measure::Measurement& measurement,
             const std::vector<fit::SelectedEffects>& effect_sets, const fit::FitOptions& options,
             const Policy& policy) {
    refuse_without_motion(measurement, options.window, policy);
    fit::NestedFits fits = fit::fit_nested({&measurement, 1}, effect_sets, options);
    Ladder ladder;
    for (fit::ModelFit& model : fits.models) {
        LadderModel& added = ladder.models.emplace_back();
        added.stated = std::move(model.stated);
        added.fit = std::move(model.judged);
    }
    const std::vector<fit::ObservedRecording> exact = fit::with_inputs_as_stated(fits.recordings);
    if (!ladder.models.front().fit.failed())
        ladder.left_out_row = row_to_leave_out(ladder.models.front().stated.parts.front());
    const HoldOut hold_out = what_to_hold_out(ladder);
    for (LadderModel& model : ladder.models) {
        ladder.comparison.emplace_back();
        if (model.fit.failed())
            continue;
        model.held_out = predict_held_out(model.stated, hold_out, exact.front(), options);
        ladder.comparison.back() = ladder.comparisons.size();
        ladder.comparisons.push_back(compare(model.stated, model.fit, measurement, policy));
    }
    // By as many candidates as diagnose() has: a model is not accepted here and refused there.
    judge_models(ladder, fit::candidate_effects({&measurement, 1}).size(), policy);
    return ladder;
}

} // namespace culm::diagnose
