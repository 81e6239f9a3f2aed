// SPDX-License-Identifier: BSD-3-Clause
#include "fit/fit_model.hpp"

#include "core/error.hpp"
#include "fit/solve/reading_errors.hpp"
#include "fit/solve/residual_statistics.hpp"
#include "fit/start/starts.hpp"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>

namespace culm::fit {
namespace {

/// Largest ratio of the residuals to those of a contained model; not 1 because the runs have noise.
constexpr double allowed_excess = 1.001;
constexpr int most_restarts = 2;
/// Decrease of χ², in units of the reduced χ², that is worth another solution.
constexpr double needed_gain = 0.5;

Fit failure(std::string reason, int runs) {
    Fit failed;
    failed.reason = std::move(reason);
    failed.runs = runs;
    return failed;
}

/// Fits of one model to the same recordings.
class ModelFits {
  public:
    /// `recordings` and `options` must outlive this; `noise` is as in JointOptions.
    ModelFits(std::span<const ObservedRecording> recordings, const FitOptions& options,
              std::vector<std::vector<double>> noise = {})
        : recordings_(recordings), options_(options), noise_(std::move(noise)) {}

    /// A complete fit from a start, or the reason why it failed.
    [[nodiscard]] Fit from(const StartModels& start, bool is_first_guess) const {
        JointOptions options{options_.solve(is_first_guess), {}, noise_};
        try {
            Fit fit = fit_jointly(start, recordings_, options);
            options.chain.is_first_guess = false;
            if (fit.status == FitStatus::NotConverged) // a long valley: continue once
                fit = continued(fit, options);
            return fit.failed() ? failure(fit.reason, fit.runs) : settled(std::move(fit), options);
        } catch (const core::NumericalError& error) {
            return failure(error.what(), 0);
        }
    }

  private:
    [[nodiscard]] Fit continued(const Fit& fit, const JointOptions& options) const {
        Fit next = fit_jointly(start_from(fit), recordings_, options);
        next.runs += fit.runs;
        return next;
    }

    /// A solution can end early where its steps meet a bound. It is restarted from there with the
    /// parameters at a bound fixed, until a restart gains nothing.
    [[nodiscard]] Fit settled(Fit fit, JointOptions options) const {
        for (int again = 0; again < most_restarts; ++again) {
            options.is_held.clear();
            for (const FittedParameter& parameter : fit.parameters)
                options.is_held.push_back(parameter.is_at_bound);
            if (std::ranges::none_of(options.is_held, [](bool held) { return held; }))
                break; // no bound limited the steps
            Fit next = continued(fit, options);
            fit.runs = next.runs;
            // Fixed parameters have no covariance, so this solution is used only if it gains
            // enough.
            if (next.failed() || !(fit.chi_squared - next.chi_squared >
                                   needed_gain * std::max(1.0, next.reduced_chi_squared)))
                break;
            fit = std::move(next);
        }
        return fit;
    }

    std::span<const ObservedRecording> recordings_;
    const FitOptions& options_;
    std::vector<std::vector<double>> noise_;
};

/// Compares residuals that are weighted by the noise of the fit.
bool is_as_good_as(const Fit& fit, std::span<const RecordingFit> smaller) {
    return !fit.failed() && fit.weighted_rms <= allowed_excess * weighted_rms(smaller, fit.noise);
}

/// Readings of unknown noise are weighted by the residuals of a smaller model, relative to other
/// recordings and to the constraints of error terms.
std::vector<std::vector<double>> noises(std::span<const RecordingFit> fits) {
    std::vector<std::vector<double>> out;
    for (const RecordingFit& fit : fits)
        out.push_back(fit.noise);
    return out;
}

/// The residuals of a stem that nothing moves are its readings.
Fit motionless(const StemModel& model, const ObservedRecording& recording,
               const FitOptions& options) {
    Fit fit = fit_jointly({&model, 1}, {&recording, 1},
                          {options.solve(), std::vector<bool>(model.free_count(), true), {}});
    fit.status = FitStatus::Motionless;
    return fit;
}

bool moves(const StartModels& models, std::span<const ObservedRecording> recordings) {
    for (std::size_t m = 0; m < models.size(); ++m)
        if (can_move(models[m], recordings[m]))
            return true;
    return false;
}

/// Fits one recording separately: the chain, or effects without which its stem is at rest.
Fit fit_alone(const StemModel& model, const ObservedRecording& recording, const Fit& smaller,
              std::size_t place, const FitOptions& options) {
    if (!can_move(model, recording)) {
        if (smaller.parts.empty())
            return motionless(model, recording, options);
        Fit still;
        still.status = FitStatus::Motionless;
        still.parts = {smaller.parts[place]};
        return still;
    }
    return ModelFits({&recording, 1}, options).from({model}, true);
}

/// Fits all recordings together, from each one's own fit of the same model.
Fit fit_together(const StartModels& models, std::span<const RecordingFit> alone,
                 std::span<const ObservedRecording> recordings, const FitOptions& options) {
    StartModels start;
    for (std::size_t m = 0; m < models.size(); ++m)
        start.push_back(started_from(models[m], alone[m]));
    // The mean of their values may be cycles away from each.
    return ModelFits(recordings, options, noises(alone)).from(start, true);
}

Fit fit_models(const StartModels& models, const Fit& smaller,
               std::span<const ObservedRecording> recordings, const FitOptions& options) {
    std::vector<RecordingFit> alone;
    int runs = 0;
    for (std::size_t m = 0; m < recordings.size(); ++m) {
        Fit own = fit_alone(models[m], recordings[m], smaller, m, options);
        runs += own.runs;
        own.runs = runs;
        if (own.failed() && recordings.size() > 1)
            own.reason = recordings[m].stem.id + " alone: " + own.reason;
        if (own.failed() || recordings.size() == 1)
            return own;
        alone.push_back(std::move(own.parts.front()));
    }
    Fit fit = fit_together(models, alone, recordings, options);
    fit.runs += runs;
    return fit;
}

StartModels observed_models(const SelectedEffects& effects,
                            std::span<const ObservedRecording> recordings,
                            const FitOptions& options) {
    StartModels models;
    for (const ObservedRecording& recording : recordings)
        models.push_back(observed_model(effects, recording, options.chain));
    return models;
}

} // namespace

Fit fit_model(const SelectedEffects& effects, const Fit& smaller,
              std::span<const ObservedRecording> recordings, const FitOptions& options) {
    Fit fit;
    try {
        const StartModels models = observed_models(effects, recordings, options);
        if (!effects.empty() && smaller.failed())
            fit.reason = "the model that it contains could not be fitted: " + smaller.reason;
        else if (!effects.empty() && !moves(models, recordings))
            fit = smaller;
        else
            fit = fit_models(models, smaller, recordings, options);
        if (!fit.failed() && !moves(models, recordings))
            fit.status = FitStatus::Motionless;
    } catch (const std::runtime_error& error) { // InputError or NumericalError
        fit.status = FitStatus::Failed;
        fit.reason = error.what();
    }
    fit.effects = effects;
    fit.names = model_names(in_library_order(effects));
    return fit;
}

Fit fit_again(const SelectedEffects& effects, std::span<const RecordingFit> from,
              std::span<const ObservedRecording> recordings, const FitOptions& options) {
    Fit fit;
    int runs = 0;
    std::vector<RecordingFit> own(from.begin(), from.end());
    for (std::size_t m = 0; m < recordings.size(); ++m) {
        fit = ModelFits(recordings.subspan(m, 1), options, {from[m].noise})
                  .from({linear_start(from[m], recordings[m])}, false);
        runs += fit.runs;
        if (fit.failed()) {
            fit.reason = fmt::format("{} with the errors of its readings: {}",
                                     recordings[m].stem.id, fit.reason);
            break;
        }
        own[m] = fit.parts.front();
    }
    if (recordings.size() > 1 && !fit.failed()) {
        fit = fit_together(observed_models(effects, recordings, options), own, recordings, options);
        fit.runs += runs;
    }
    fit.effects = effects;
    fit.names = model_names(in_library_order(effects));
    return fit;
}

Fit refined(const StartModels& start, const SelectedEffects& effects, const Fit& smaller,
            std::span<const ObservedRecording> recordings, const FitOptions& options) {
    const ModelFits fits(recordings, options, noises(smaller.parts));
    Fit fit = fits.from(start, false);
    if (is_nested(start.front()) && !is_as_good_as(fit, smaller.parts)) { // it skipped a cycle
        Fit again = fits.from(start, true);
        const int runs = fit.runs + again.runs;
        if (fit.failed() || (!again.failed() && again.weighted_rms < fit.weighted_rms))
            fit = std::move(again);
        fit.runs = runs;
        if (!fit.failed() && !is_as_good_as(fit, smaller.parts)) {
            const measure::ReadingUnit unit =
                measure::reading_unit(smaller.parts.front().model.spec.sensors);
            fit = failure(
                fmt::format("no start leads to a fit as good as that of the model it contains (rms "
                            "{:.4g} {}, without it {:.4g} {})",
                            unit.factor * fit.rmse, unit.name, unit.factor * rms(smaller.parts),
                            unit.name),
                fit.runs);
        }
    }
    fit.effects = effects;
    fit.names = model_names(in_library_order(effects));
    return fit;
}

double relative_cost(const SelectedEffects& effects) {
    constexpr double of_spatial = 2.0; // two planar chains
    return std::ranges::any_of(effects,
                               [](const auto& each) { return each.effect->dimensions() > 2; })
               ? of_spatial
               : 1.0;
}

} // namespace culm::fit
