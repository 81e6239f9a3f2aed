// SPDX-License-Identifier: BSD-3-Clause
#include "fit/fit_model.hpp"

#include "core/error.hpp"
#include "fit/chain/baseline_model.hpp"
#include "measure/folder/measurement.hpp"

#include <stdexcept>
#include <utility>

#include <fmt/format.h>

namespace culm::fit {
namespace {

/// Largest ratio of the residuals to those of a contained model; not 1 because the runs have noise.
constexpr double allowed_excess = 1.001;

Fit failure(std::string reason, int batches) {
    Fit failed;
    failed.reason = std::move(reason);
    failed.batches = batches;
    return failed;
}

/// A fit from a start, or the reason why it failed.
Fit fitted(const StartModels& start, std::span<const ObservedRecording> recordings,
           JointOptions options) {
    try {
        Fit fit = fit_jointly(start, recordings, std::move(options));
        return fit.failed() ? failure(fit.reason, fit.batches) : fit;
    } catch (const core::NumericalError& error) {
        return failure(error.what(), 0);
    }
}

/// Readings of unknown noise are weighted by the residuals of a smaller model, relative to other
/// recordings and to the constraints of error terms.
std::vector<std::vector<double>> noises(const Fit& fit) {
    std::vector<std::vector<double>> out;
    for (const RecordingFit& part : fit.parts)
        out.push_back(part.noise);
    return out;
}

bool is_as_good_as(const Fit& fit, const Fit& smaller) {
    return !fit.failed() && fit.weighted_rms <= allowed_excess * smaller.own_weighted_rms;
}

/// The residuals of a stem that nothing moves are its readings.
Fit motionless(const StartModels& models, std::span<const ObservedRecording> recordings,
               const FitOptions& options) {
    JointOptions held{options};
    held.with_inputs = false;
    held.is_held = true;
    Fit fit = fit_jointly(models, recordings, held);
    fit.status = FitStatus::Motionless;
    return fit;
}

bool moves(const StartModels& models, std::span<const ObservedRecording> recordings) {
    for (std::size_t m = 0; m < models.size(); ++m)
        if (can_move(models[m], recordings[m]))
            return true;
    return false;
}

} // namespace

StemModel observed_model(const SelectedEffects& effects, const ObservedRecording& recording,
                         const ChainOptions& options) {
    return candidate_model(with_error_terms(baseline_model(recording, options), recording), effects,
                           recording);
}

Fit fit_model(const SelectedEffects& effects, const Fit& smaller,
              std::span<const ObservedRecording> recordings, const FitOptions& options) {
    Fit fit;
    try {
        StartModels models;
        for (const ObservedRecording& recording : recordings)
            models.push_back(observed_model(effects, recording, options.chain));
        if (!effects.empty() && smaller.failed())
            fit.reason = "the model that it contains could not be fitted: " + smaller.reason;
        else if (moves(models, recordings))
            fit = fitted(models, recordings, {options, false, noises(smaller), {}, {}, true});
        else
            fit = effects.empty() ? motionless(models, recordings, options) : smaller;
    } catch (const std::runtime_error& error) { // InputError or NumericalError
        fit = failure(error.what(), fit.batches);
    }
    fit.effects = effects;
    return fit;
}

Fit fit_near(const std::vector<StartModels>& starts, const SelectedEffects& effects,
             const Fit& smaller, std::span<const ObservedRecording> recordings,
             const FitOptions& options, std::vector<KnownPoint> known) {
    const auto fit_from = [&](const StartModels& start, JointOptions joint) {
        Fit fit = fitted(start, recordings, std::move(joint));
        if (fit.failed() || smaller.parts.empty() || !is_nested(start.front()) ||
            is_as_good_as(fit, smaller))
            return fit;
        const measure::ReadingUnit unit =
            measure::reading_unit(smaller.parts.front().model.spec.sensors);
        return failure(fmt::format("no start leads to a fit as good as that of the model it "
                                   "contains (rms {:.4g} {}, without it {:.4g} {})",
                                   unit.factor * fit.rmse, unit.name, unit.factor * smaller.rmse,
                                   unit.name),
                       fit.batches);
    };
    Fit fit = fit_from(
        starts.front(),
        {options, false, noises(smaller), std::move(known), {starts.begin() + 1, starts.end()}});
    if (const int batches = fit.batches; fit.failed() && starts.size() > 1) {
        fit = fit_from(starts.back(), {options, false, noises(smaller)});
        fit.batches += batches;
    }
    fit.effects = effects;
    return fit;
}

Fit fit_again(const Fit& before, const Fit& smaller, std::span<const ObservedRecording> recordings,
              const FitOptions& options, const std::vector<std::vector<double>>& added) {
    StartModels start;
    std::vector<KnownPoint> known;
    for (std::size_t m = 0; m < before.parts.size(); ++m) {
        const RecordingFit& part = before.parts[m];
        start.push_back(with_error_terms(part.model, recordings[m]));
        KnownPoint& point = known.emplace_back(known_point(part));
        for (std::size_t at = 0; m < added.size() && at < added[m].size(); ++at)
            point.prediction.readings[at] += added[m][at];
    }
    for (std::size_t m = 0; m < start.size(); ++m)
        if (start[m].error_values.size() != before.parts[m].model.error_values.size())
            known.clear(); // the predictions have no derivatives by the new terms
    Fit fit = fit_near({start}, before.effects, smaller, recordings, options, std::move(known));
    fit.batches += before.batches;
    return fit;
}

double relative_cost(const SelectedEffects& effects) {
    double cost = 1.0;
    double planes = 1.0; // planar chains of a run
    for (const physics::SelectedEffect& each : effects) {
        cost += static_cast<double>(each.effect->parameters.size());
        if (each.effect->dimensions > 2)
            planes = 2.0;
    }
    return planes * cost;
}

} // namespace culm::fit
