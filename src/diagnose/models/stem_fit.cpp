// SPDX-License-Identifier: BSD-3-Clause
#include "diagnose/models/stem_fit.hpp"

#include "core/error.hpp"
#include "diagnose/adequacy.hpp"
#include "diagnose/evidence/estimated_starts.hpp"

#include <algorithm>
#include <array>
#include <numeric>
#include <stdexcept>
#include <utility>

namespace culm::diagnose {
namespace {

StemFit finished(const fit::Fit& fit, const Stems& stems, std::size_t stem,
                 const StemEffects& effects) {
    StemFit out;
    const std::vector<fit::ObservedRecording>& recordings = stems[stem].recordings;
    if (!fit.failed()) {
        out.evidence = evidence_of(fit, recordings, effects.given, effects.sharing.held());
        out.verdict = verdict_on(fit, recordings, stems.options().policy);
        out.block = block_of(shared_columns(fit, recordings, effects.sharing));
    }
    out.fit = stems.to_message(fit);
    return out;
}

fit::FitOptions with_held(fit::FitOptions options, const StemEffects& effects) {
    options.held_effects = effects.sharing.held();
    return options;
}

/// They change neither the parts nor the system of a fit.
fit::FitOptions without_moved_inputs(fit::FitOptions options) {
    options.moves_inputs = false;
    return options;
}

/// Sets the numbers of the rig's effects, within the bounds that suit the stem.
void set_shared_values(const Model& model, fit::StemModel& stem) {
    for (const ActingEffect& each : model.effects) {
        const std::vector<physics::EffectParameter>& cards = each.effect.effect->parameters;
        for (const fit::FreeParameter& parameter : stem.parameters)
            for (std::size_t k = 0; k < cards.size() && each.is_shared(); ++k)
                if (parameter.access.id.effect == each.name() &&
                    parameter.access.id.name == cards[k].name)
                    parameter.access.set(
                        stem.spec, std::clamp(each.values[k], parameter.lower, parameter.upper));
    }
}

/// The stem's numbers in the model, after a change. Effects that its fit does not have change the
/// first mode, so Y and β keep it.
fit::StartModels start_at_shared(const Stems& stems, std::size_t stem, const Model& model,
                                 const fit::SelectedEffects& effects, const Eigen::VectorXd& change,
                                 const fit::FitOptions& options) {
    const std::vector<fit::ObservedRecording>& recordings = stems[stem].recordings;
    const fit::Fit& from = model.stems[stem].fit;
    fit::Fit wanted = from;
    wanted.effects = effects;
    fit::StartModels models = fit::models_of(wanted, recordings, options);
    if (change.size() > 0) {
        const fit::JointLayout layout = fit::joint_layout(models, recordings);
        models = fit::in_valley(
            [&](double share) { return fit::moved(models, layout, share * change); }, layout);
    }
    for (fit::StemModel& each : models)
        set_shared_values(model, each);
    if (change.size() == 0 && models.size() == 1)
        fit::keep_first_mode(fit::models_of(from, recordings, options).front().spec,
                             models.front());
    return models;
}

} // namespace

fit::Fit base_fit(const Stems& stems, std::size_t stem, const Model& model,
                  const fit::FitOptions& options) {
    return fit::rerun(model.stems[stem].fit, stems[stem].recordings,
                      without_moved_inputs(with_held(options, model.effects_of(stem, stems))));
}

fit::Fit fit_larger(const fit::SelectedEffects& effects, const fit::Fit& smaller,
                    std::span<const fit::ObservedRecording> recordings,
                    const fit::FitOptions& options) {
    if (!smaller.moves() || smaller.failed())
        return fit::fit_model(effects, smaller, recordings, options);
    int batches = 0;
    fit::Fit fit;
    fit::SelectedEffects added = fit::in_library_order(effects);
    std::erase_if(added, [&](const auto& each) { return fit::contains(smaller.effects, each); });
    if (added.empty())
        return smaller;
    try {
        std::vector<EffectColumns> candidates;
        for (const physics::SelectedEffect& effect : added) {
            candidates.push_back(effect_columns(smaller, effect, recordings, options));
            batches += candidates.back().batches;
            if (const std::string& failure = candidates.back().failure; !failure.empty())
                throw core::NumericalError(core::FailureKind::FitFailed, failure);
        }
        std::vector<std::size_t> all(candidates.size());
        std::iota(all.begin(), all.end(), 0);
        Sharing held;
        for (const std::string& name : options.held_effects)
            held.rig_of[name] = {};
        const SharedColumns columns = shared_columns(smaller, recordings, held);
        const EffectView view = view_of(std::move(candidates), columns);
        const LinearEvidence evidence(view.columns, view.gram, view.overlap);
        PredictedGain gain = evidence.gain(all);
        if (gain.points.empty() && added.size() > 1) { // the likeliest effect first
            const auto best = std::ranges::max_element(
                all, {}, [&](std::size_t k) { return evidence.gain(std::array{k}).log_evidence; });
            fit::SelectedEffects first = smaller.effects;
            first.push_back(added[*best]);
            if (const fit::Fit one = fit_larger(first, smaller, recordings, options);
                !one.failed()) {
                fit = fit_larger(effects, one, recordings, options);
                fit.batches += batches + one.batches;
                return fit;
            }
        }
        if (gain.points.empty()) { // all allowed sizes make the fit worse: it starts without them
            gain.points.emplace_back();
            for (const EffectColumns& each : view.columns)
                gain.points.front().effects.push_back(
                    {.amounts = std::vector(each.nodes.front().columns.size(), 0.0)});
        }
        fit::SelectedEffects larger = smaller.effects;
        larger.insert(larger.end(), added.begin(), added.end());
        fit = fit::fit_near(
            starts_to_estimate({smaller, recordings, columns, added, view}, all, gain), larger,
            smaller, recordings, options);
        batches += fit.batches;
    } catch (const std::runtime_error& error) { // InputError or NumericalError
        fit.reason = error.what();
    }
    fit.batches = batches;
    fit.effects = effects;
    return fit;
}

StemFit fit_stem(const Stems& stems, std::size_t stem, const StemEffects& effects,
                 const StemStart& start, const fit::FitOptions& options) {
    const fit::FitOptions held = with_held(options, effects);
    const std::vector<fit::ObservedRecording>& recordings = stems[stem].recordings;
    const fit::Fit smaller = fit::rerun(*start.smaller, recordings, without_moved_inputs(held));
    return finished(start.starts ? fit::fit_near(start.starts(&smaller, held), effects.all, smaller,
                                                 recordings, held)
                                 : fit_larger(effects.all, smaller, recordings, held),
                    stems, stem, effects);
}

StemFit fit_at_shared(const Stems& stems, std::size_t stem, const Model& model,
                      const Eigen::VectorXd& change, const StemStart& start,
                      const fit::FitOptions& options) {
    const StemEffects effects = model.effects_of(stem, stems);
    const std::vector<fit::ObservedRecording>& recordings = stems[stem].recordings;
    const fit::FitOptions held = with_held(options, effects);
    fit::Fit fit;
    try {
        fit = fit::fit_jointly(start.starts
                                   ? start.starts(nullptr, held).front()
                                   : start_at_shared(stems, stem, model, effects.all, change, held),
                               recordings, {held, false, stems[stem].noise});
    } catch (const core::NumericalError& error) {
        fit.status = fit::FitStatus::Failed;
        fit.reason = error.what();
    }
    fit.effects = effects.all;
    return finished(fit, stems, stem, effects);
}

std::vector<EffectColumns> columns_about(const Stems& stems, std::size_t stem, const fit::Fit& base,
                                         std::size_t first, std::size_t last,
                                         const fit::FitOptions& options) {
    std::vector<EffectColumns> out;
    for (std::size_t c = first; c < last; ++c) {
        const physics::SelectedEffect& candidate = stems.options().candidates[c];
        fit::SelectedEffects larger = base.effects;
        larger.push_back(candidate);
        if (fit::contains(base.effects, candidate))
            out.push_back({"it is in the model", {}, 0});
        else if (!can_be_combined(larger))
            out.push_back({combination_failure, {}, 0});
        else
            out.push_back(effect_columns(base, candidate, stems[stem].recordings, options));
    }
    return out;
}

} // namespace culm::diagnose
