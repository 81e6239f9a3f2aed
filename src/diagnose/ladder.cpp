// SPDX-License-Identifier: BSD-3-Clause
#include "diagnose/ladder.hpp"

#include "diagnose/evidence/log_evidence.hpp"
#include "diagnose/models/stem_fit.hpp"
#include "fit/chain/baseline_model.hpp"
#include "fit/fit_numbers.hpp"
#include "residuals/swing.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <fmt/format.h>

namespace culm::diagnose {
namespace {

double relative_change(const fit::Fit& now, const fit::Fit& before,
                       double physics::StemParameters<double>::*member) {
    return now.parts.front().model.spec.stem.*member /
               before.parts.front().model.spec.stem.*member -
           1.0;
}

/// Uses the noise about the best model, as in a search: its residual is noise to all models.
void add_log_evidence(Ladder& ladder, std::span<const fit::ObservedRecording> recordings) {
    const auto is_usable = [&](const LadderModel& model) {
        return !model.fit.failed() && (model.fit.is_fitted() || &model == &ladder.models.front());
    };
    const auto best = std::ranges::min_element(ladder.models, {}, [&](const LadderModel& model) {
        return is_usable(model) ? deviance(model.fit) : std::numeric_limits<double>::infinity();
    });
    if (!is_usable(*best))
        return;
    const NoiseScale noise = noise_scale_of(best->fit);
    for (LadderModel& model : ladder.models) {
        const ModelEvidence evidence =
            is_usable(model) ? evidence_of(model.fit, recordings, {}) : ModelEvidence{};
        model.log_evidence = evidence.misfits.empty() || !evidence.absent_effects.empty()
                                 ? -std::numeric_limits<double>::infinity()
                                 : log_evidence(evidence, noise);
    }
    const double of_chain = ladder.models.front().log_evidence;
    for (LadderModel& model : ladder.models)
        model.log_evidence -= of_chain;
}

std::string why(const LadderModel& model, double least_gain) {
    if (model.fit.failed())
        return "failed: " + model.fit.reason;
    if (!model.fit.moves())
        return "nothing moves the stem in this model";
    if (!std::isfinite(model.log_evidence))
        return "every size of an added effect is at the bound where the effect is absent";
    const std::string change = fmt::format(
        "the log evidence {} by {:.{}f}", model.log_evidence_gain < 0.0 ? "falls" : "rises",
        std::abs(model.log_evidence_gain), std::abs(model.log_evidence_gain) < 10.0 ? 1 : 0);
    return model.log_evidence_gain < 0.0 || model.is_gain
               ? change
               : fmt::format("{}, less than {:.1f}", change, least_gain);
}

/// The largest fitted model within `effects`; the chain itself if there is none.
const fit::Fit& model_within(const fit::SelectedEffects& effects,
                             const std::vector<fit::Fit>& models) {
    const fit::Fit* within = &models.front();
    for (const fit::Fit& model : models)
        if (!model.failed() && contains_all(effects, model.effects))
            within = &model;
    return *within;
}

void judge_models(Ladder& ladder, const Policy& policy) {
    const double held = policy.held_probability;
    const double least_gain = std::log(held / (1.0 - held));
    std::size_t best = 0;
    for (std::size_t k = 1; k < ladder.models.size(); ++k) {
        LadderModel& model = ladder.models[k];
        const LadderModel& before = ladder.models[best];
        model.compared_with = best;
        for (const physics::SelectedEffect& effect : fit::in_library_order(model.fit.effects))
            if (!fit::contains(before.fit.effects, effect))
                model.added.push_back(effect.effect->name);
        model.log_evidence_gain = model.log_evidence - before.log_evidence;
        model.is_gain = model.fit.is_fitted() && model.log_evidence_gain >= least_gain;
        model.why = why(model, least_gain);
        if (model.fit.failed())
            continue;
        if (before.fit.moves()) {
            model.modulus_change = relative_change(
                model.fit, before.fit, &physics::StemParameters<double>::bond_youngs_modulus);
            model.damping_change = relative_change(model.fit, before.fit,
                                                   &physics::StemParameters<double>::bond_damping);
        }
        if (model.log_evidence > before.log_evidence)
            best = k;
    }
}

} // namespace

NestedFits fit_nested(std::span<const measure::Measurement> measurements,
                      const std::vector<fit::SelectedEffects>& effect_sets,
                      const fit::FitOptions& options) {
    for (const measure::Measurement& recording : measurements) { // throws if a model is invalid
        const fit::StemModel chain = fit::baseline_model(recording, options.chain);
        for (const fit::SelectedEffects& effects : effect_sets)
            static_cast<void>(fit::candidate_model(chain, effects, recording));
    }
    fit::BaselineFit baseline = fit::fit_baseline(measurements, options);
    std::vector<fit::Fit> models{baseline.fit};
    for (const fit::SelectedEffects& effects : effect_sets)
        models.push_back(
            fit_larger(effects, model_within(effects, models), baseline.recordings, options));
    // The first estimate of the noise may contain the missing effect.
    const fit::Fit* last = nullptr;
    for (const fit::Fit& model : models)
        if (!model.failed() && model.moves() && !model.effects.empty())
            last = &model;
    if (last != nullptr)
        if (std::optional<fit::BaselineFit> again =
                fit::baseline_with_noise_about(*last, baseline, measurements, options);
            again && !again->fit.failed()) {
            baseline = *std::move(again);
            models.front() = baseline.fit;
            for (std::size_t k = 1; k < models.size(); ++k)
                if (!models[k].failed() && models[k].moves())
                    models[k] =
                        fit::fit_again(models[k], models.front(), baseline.recordings, options);
        }
    return {std::move(baseline.recordings), std::move(models)};
}

Comparison compare(const fit::Fit& model, std::size_t part, const measure::Measurement& measurement,
                   const Policy& policy) {
    constexpr std::size_t parts = 3;
    const fit::RecordingFit& fit = model.parts[part];
    Comparison result;
    result.moves = model.moves();
    result.id = measurement.stem.id;
    result.verdict = verdict_on(fit, residuals::swing_of(fit, measurement), policy);
    result.unit = measure::reading_unit(measurement.sensors);
    result.rmse = fit.rmse;
    result.noise = typical_noise(fit);
    result.over_noise = over_noise(fit);
    result.by_height = residuals_by_height(fit);
    result.by_time = residuals_by_time(fit, parts);
    result.spectrum = residual_spectrum(fit);
    result.backbones = residuals::backbones_of_both(fit, measurement);
    residuals::RingDownsOfBoth ring_downs = residuals::ring_downs_of_both(fit, measurement);
    result.measured_ring_downs = std::move(ring_downs.measured);
    result.modelled_ring_downs = std::move(ring_downs.modelled);
    return result;
}

Ladder climb(const measure::Measurement& measurement,
             const std::vector<fit::SelectedEffects>& effect_sets, const fit::FitOptions& options,
             const Policy& policy) {
    refuse_without_motion(measurement, options.window);
    NestedFits fits = fit_nested({&measurement, 1}, effect_sets, options);
    Ladder ladder;
    for (fit::Fit& model : fits.models) {
        LadderModel& added = ladder.models.emplace_back();
        added.fit = std::move(model);
        if (!added.fit.failed())
            added.comparison = compare(added.fit, 0, measurement, policy);
    }
    add_log_evidence(ladder, fits.recordings);
    judge_models(ladder, policy);
    return ladder;
}

} // namespace culm::diagnose
