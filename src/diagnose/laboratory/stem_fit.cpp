// SPDX-License-Identifier: BSD-3-Clause
#include "diagnose/laboratory/stem_fit.hpp"

#include "core/error.hpp"
#include "diagnose/evidence/linear_evidence.hpp"
#include "diagnose/planned_model.hpp"
#include "fit/start/starts.hpp"
#include "physics/effects/library.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <utility>

#include <fmt/format.h>

namespace culm::diagnose {
namespace {

template <class T>
std::optional<T> value_of(const std::shared_ptr<const T>& pointer) {
    return pointer ? std::optional<T>(*pointer) : std::nullopt;
}
template <class T>
std::shared_ptr<const T> pointer_to(const std::optional<T>& value) {
    return value ? std::make_shared<const T>(*value) : nullptr;
}

StemBaseline to_message(fit::BaselineFit baseline) {
    StemBaseline out;
    if (baseline.fit.failed()) {
        out.failure = baseline.fit.reason;
        return out;
    }
    for (const fit::ObservedRecording& recording : baseline.recordings) {
        out.noise_models.push_back(value_of(recording.noise_model));
        out.errors.push_back(value_of(recording.errors));
        out.terms.push_back(recording.terms ? *recording.terms : std::vector<fit::ErrorTerm>{});
    }
    for (const fit::RecordingFit& part : baseline.fit.parts)
        out.noise.push_back(part.noise);
    out.chain = fit::to_numbers(baseline.fit);
    return out;
}

/// Numbers of a fit that includes all its parts.
StemFit finished(fit::Fit fit, const ObservedStem& stem, const StemEffects& effects,
                 const fit::FitOptions& options) {
    StemFit out;
    if (!fit.failed()) {
        out.evidence = evidence_of(fit, stem.recordings, effects.given());
        out.block = block_of(shared_readings(fit, stem.recordings, effects.rig,
                                             effects.shared_terms, options.heartbeat));
    }
    out.fit = fit::to_numbers(fit);
    return out;
}

/// Models with the numbers of `from`. Effects that it does not have change the first mode, so Y
/// and β keep it.
fit::StartModels start_models(const ObservedStem& stem, const fit::SelectedEffects& effects,
                              const fit::Fit& from, const fit::FitOptions& options) {
    fit::Fit wanted = from;
    wanted.effects = effects;
    fit::StartModels models = fit::models_of(wanted, stem.recordings, options);
    if (models.size() == 1)
        fit::keep_first_mode(fit::models_of(from, stem.recordings, options).front().spec,
                             models.front());
    return models;
}

void scale_readings(double factor, fit::WeightedSystem& system) {
    system.jacobian.topRows(system.readings()) *= factor;
    system.residual.head(system.readings()) *= factor;
}

EffectColumns columns_about(const fit::Fit& base, const physics::SelectedEffect& candidate,
                            const ObservedStem& stem, const fit::FitOptions& options) {
    fit::SelectedEffects larger = base.effects;
    larger.push_back(candidate);
    if (fit::contains(base.effects, candidate))
        return {"it is in the model", {}, 0};
    if (!can_be_combined(larger))
        return {"it cannot be combined with the model", {}, 0};
    return effect_columns(base, candidate, stem.recordings, options);
}

/// Of the candidate's free parameters.
std::vector<ParameterPrior> priors_of(const physics::SelectedEffect& candidate,
                                      const fit::Fit& base, const ObservedStem& stem) {
    const fit::StemModel model =
        candidate_model(base.parts.front().model, {candidate}, stem.recordings.front());
    std::vector<ParameterPrior> priors;
    for (const fit::FreeParameter& parameter : model.parameters)
        if (parameter.access.id.effect == candidate.effect->name())
            priors.push_back(prior_of(parameter, model));
    return priors;
}

} // namespace

std::vector<Specimen> specimens_of(std::span<const measure::Measurement> measurements) {
    std::vector<Specimen> specimens;
    for (const measure::Measurement& recording : measurements) {
        const std::string& name = recording.specimen_name();
        auto found = std::ranges::find(specimens, name, &Specimen::name);
        if (found == specimens.end())
            found = specimens.insert(specimens.end(), {name, recording.rig, {}});
        if (found->rig != recording.rig)
            throw core::InputError(
                fmt::format("{} and {} are recordings of specimen \"{}\" on different rigs "
                            "(\"{}\", \"{}\"): a stem of a laboratory is on one rig; diagnose the "
                            "specimen alone, or correct stem.rig in stem.toml",
                            found->recordings.front().stem.id, recording.stem.id, name, found->rig,
                            recording.rig));
        found->recordings.push_back(recording);
    }
    return specimens;
}

StemBaseline baseline_of(const Specimen& specimen, const fit::FitOptions& options) {
    try {
        return to_message(fit::fit_baseline(specimen.recordings, options));
    } catch (const core::NumericalError& error) {
        return {error.what(), {}, {}, {}, {}, {}};
    }
}

ObservedStem observed_stem(const Specimen& specimen, StemBaseline baseline) {
    ObservedStem stem{std::move(baseline), fit::observed(specimen.recordings)};
    for (std::size_t m = 0; m < stem.noise_models.size(); ++m) {
        stem.recordings[m].noise_model = pointer_to(stem.noise_models[m]);
        stem.recordings[m].errors = pointer_to(stem.errors[m]);
        stem.recordings[m].terms =
            std::make_shared<const std::vector<fit::ErrorTerm>>(stem.terms[m]);
    }
    return stem;
}

std::optional<StemBaseline> baseline_with_noise_about(const fit::Fit& best,
                                                      const Specimen& specimen,
                                                      const ObservedStem& stem,
                                                      const fit::FitOptions& options) {
    const fit::BaselineFit before{stem.recordings,
                                  fit::rerun(stem.chain, stem.recordings, options)};
    std::optional<fit::BaselineFit> again = fit::baseline_with_noise_about(
        fit::rerun(best, stem.recordings, options), before, specimen.recordings, options);
    if (!again || again->fit.failed())
        return std::nullopt;
    return to_message(*std::move(again));
}

fit::SelectedEffects StemEffects::given() const {
    fit::SelectedEffects effects = known;
    for (const RigEffect& each : rig) {
        physics::SelectedEffect selected = each.effect;
        const std::vector<physics::EffectParameter> parameters = selected.effect->parameters();
        for (std::size_t k = 0; k < parameters.size(); ++k)
            if (parameters[k].calibrated)
                selected.fixed[k] = each.values[k];
        effects.push_back(std::move(selected));
    }
    return effects;
}

fit::SelectedEffects StemEffects::all() const {
    fit::SelectedEffects effects = given();
    effects.insert(effects.end(), own.begin(), own.end());
    return effects;
}

StemFit fit_stem(const ObservedStem& stem, const StemEffects& effects, const fit::Fit& from,
                 const Eigen::VectorXd& change, const fit::FitOptions& options) {
    fit::Fit fit;
    const fit::SelectedEffects all = effects.all();
    try {
        fit::StartModels models = start_models(stem, all, from, options);
        if (change.size() > 0) {
            const fit::JointLayout layout = fit::joint_layout(models, stem.recordings);
            models = fit::in_valley(
                [&](double share) { return fit::moved(models, layout, share * change); }, layout);
        }
        fit = fit::fit_jointly(models, stem.recordings, {options, {}, stem.noise});
    } catch (const core::NumericalError& error) {
        fit.status = fit::FitStatus::Failed;
        fit.reason = error.what();
    }
    fit.effects = all;
    return finished(std::move(fit), stem, effects, options);
}

StemFit fit_stem_from_starts(const ObservedStem& stem, const StemEffects& effects,
                             const fit::Fit& from, const fit::FitOptions& options) {
    const fit::Fit smaller = fit::rerun(from, stem.recordings, options);
    FittedModel found = fit_planned({effects.all(), not_predicted, {}}, smaller, stem.recordings,
                                    effects.given(), {}, options);
    found.fit.effects = effects.all();
    if (found.fit.failed())
        return {std::move(found.fit), {}, {}};
    return finished(fit::rerun(found.fit, stem.recordings, options), stem, effects, options);
}

StemSurvey survey_of(const ObservedStem& stem, const StemEffects& effects, const fit::Fit& numbers,
                     bool has_rig, const fit::SelectedEffects& candidates,
                     const fit::FitOptions& options) {
    const fit::Fit base = fit::rerun(numbers, stem.recordings, options);
    fit::WeightedSystem system = base.system;
    SharedReadings shared = shared_readings(base, stem.recordings, effects.rig,
                                            effects.shared_terms, options.heartbeat);
    // The residual of the best model is noise to all larger ones.
    const double weight = 1.0 / std::sqrt(noise_scale_of(base).mean_known());
    StemSurvey out;
    std::vector<CandidateView> views;
    for (const physics::SelectedEffect& candidate : candidates) {
        views.push_back({candidate, columns_about(base, candidate, stem, options)});
        out.priors.push_back(views.back().columns.failure.empty() ? priors_of(candidate, base, stem)
                                                                  : std::vector<ParameterPrior>{});
        for (EffectNode& node : views.back().columns.nodes)
            for (EffectColumn& column : node.columns)
                for (double& reading : column.readings)
                    reading *= weight;
    }
    scale_readings(weight, system);
    scale_readings(weight, shared.system);
    shared.columns.topRows(system.readings()) *= weight;
    const LinearEvidence alone(system, views);
    for (std::size_t k = 0; k < views.size(); ++k) {
        const std::size_t one[] = {k};
        out.own_gains.push_back(views[k].columns.failure.empty()
                                    ? alone.gain(one).log_evidence - log_prior_odds()
                                    : -std::numeric_limits<double>::infinity());
    }
    out.shared = shared.names;
    out.shared_at = shared.at;
    for (CandidateView& view : views) {
        const bool is_of_rig =
            has_rig && view.effect.effect->belongs_to() == physics::BelongsTo::Rig;
        if (!is_of_rig && view.columns.failure.empty())
            view.columns = {"it is of the stem", {}, 0};
    }
    const Eigen::MatrixXd columns = column_matrix(views, system.residual.size());
    Eigen::MatrixXd all(columns.rows(), columns.cols() + shared.columns.cols());
    all.leftCols(columns.cols()) = columns;
    all.rightCols(shared.columns.cols()) = shared.columns;
    const fit::Projector own(shared.system.jacobian(Eigen::all, shared.own));
    const Eigen::MatrixXd remainder = own.remainder(all);
    const Eigen::MatrixXd gram = remainder.transpose() * remainder;
    const Eigen::VectorXd overlap = remainder.transpose() * shared.system.residual;
    out.gram.assign(gram.data(), gram.data() + gram.size());
    out.overlap.assign(overlap.data(), overlap.data() + overlap.size());
    for (CandidateView& view : views) {
        for (EffectNode& node : view.columns.nodes)
            for (EffectColumn& column : node.columns)
                column.readings.clear();
        out.rig_columns.push_back(std::move(view.columns));
    }
    return out;
}

} // namespace culm::diagnose
