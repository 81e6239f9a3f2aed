// SPDX-License-Identifier: BSD-3-Clause
#include "fit/fit_model.hpp"
#include "fit/solve/reading_errors.hpp"

#include <optional>
#include <utility>
#include <vector>

#include <fmt/core.h>

namespace culm::fit {

namespace {

/// The chain beside the errors that `known` has, from the fits without them.
BaselineFit fit_beside(std::vector<measure::Measurement> known, std::vector<RecordingFit> alone,
                       const FitOptions& options) {
    const Fit none; // the chain itself has no smaller model
    Fit fit;
    int runs = 0;
    std::vector<RecordingFit> beside = alone;
    for (std::size_t m = 0; m < known.size(); ++m) {
        fit = FitPlan({}, none, {&known[m], 1}, options).fit_beside_errors(alone[m], options);
        runs += fit.runs;
        if (fit.failed()) {
            fit.reason = fmt::format("{} beside the errors of its readings: {}", known[m].stem.id,
                                     fit.reason);
            break;
        }
        beside[m] = fit.parts.front();
    }
    if (known.size() > 1 && !fit.failed())
        fit = FitPlan({}, none, known, options).fit_from_alone(beside, options);
    fit.names = model_names({});
    fit.runs += runs;
    return {std::move(known), std::move(fit), std::move(alone)};
}

/// A fit to a recording as it was measured, whatever was made of its noise since.
RecordingFit as_measured(RecordingFit fit, const measure::Measurement& measured,
                         const measure::Measurement& fitted) {
    ReadingNoise noise = reading_noise(measured);
    if (!noise.by_row.empty()) {
        fit.noise = std::move(noise.by_row);
        fit.noise_source = std::move(noise.source);
    }
    for (std::size_t at = 0; at < fit.residuals.size(); ++at)
        fit.residuals[at] += measured.deflections[at] - fitted.deflections[at];
    return fit;
}

} // namespace

// Terms are linear about a recording's own fit: where recordings disagree, a joint one may be
// cycles away from each of them.
BaselineFit fit_baseline(std::span<const measure::Measurement> recordings,
                         const FitOptions& options) {
    BaselineFit out{{recordings.begin(), recordings.end()}, {}};
    std::vector<RecordingFit> alone;
    int runs = 0;
    for (const measure::Measurement& recording : recordings) {
        Fit own = fit_model({}, {}, {&recording, 1}, options);
        runs += own.runs;
        if (own.failed() || !own.moves()) {
            out.fit =
                recordings.size() > 1 ? fit_model({}, {}, recordings, options) : std::move(own);
            return out;
        }
        alone.push_back(std::move(own.parts.front()));
    }
    std::vector<measure::Measurement> known =
        with_reading_errors(recordings, alone, options.heartbeat);
    out = fit_beside(std::move(known), std::move(alone), options);
    out.fit.runs += runs;
    return out;
}

std::optional<BaselineFit>
baseline_beside_noise_of(const Fit& larger, const BaselineFit& baseline,
                         std::span<const measure::Measurement> recordings,
                         const FitOptions& options) {
    if (baseline.alone.empty() || larger.failed())
        return std::nullopt;
    std::vector<measure::Measurement> known = baseline.recordings;
    bool is_other = false;
    for (std::size_t m = 0; m < known.size(); ++m) {
        known[m] = with_noise_in_motion(as_measured(larger.parts[m], recordings[m], known[m]),
                                        recordings[m]);
        known[m].errors = baseline.recordings[m].errors;
        // That says its size, tails and correlation.
        is_other = is_other || known[m].noise_source != baseline.recordings[m].noise_source;
    }
    if (!is_other)
        return std::nullopt;
    return fit_beside(std::move(known), baseline.alone, options);
}

Fit fit_model(const SelectedEffects& effects, const Fit& smaller,
              std::span<const measure::Measurement> recordings, const FitOptions& options) {
    const FitPlan plan(effects, smaller, recordings, options);
    std::vector<std::optional<BegunStart>> begun;
    for (std::size_t k = 0; k < plan.start_count(); ++k)
        begun.push_back(plan.begin(k, options));
    return plan.finish(begun, options);
}

} // namespace culm::fit
