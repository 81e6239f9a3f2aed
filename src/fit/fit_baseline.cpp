// SPDX-License-Identifier: BSD-3-Clause
#include "fit/fit_model.hpp"
#include "fit/solve/reading_errors.hpp"

#include <optional>
#include <utility>
#include <vector>

#include <fmt/core.h>

namespace culm::fit {

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
    const Fit none; // the chain itself has no smaller model
    Fit fit;
    for (std::size_t m = 0; m < known.size(); ++m) {
        fit = FitPlan({}, none, {&known[m], 1}, options).fit_beside_errors(alone[m], options);
        runs += fit.runs;
        if (fit.failed()) {
            out.fit.reason = fmt::format("{} beside the errors of its readings: {}",
                                         recordings[m].stem.id, fit.reason);
            return out;
        }
        alone[m] = fit.parts.front();
    }
    if (recordings.size() > 1)
        fit = FitPlan({}, none, known, options).fit_from_alone(alone, options);
    fit.names = model_names({});
    fit.runs += runs;
    return {std::move(known), std::move(fit)};
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
