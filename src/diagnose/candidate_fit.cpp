// SPDX-License-Identifier: BSD-3-Clause
#include "diagnose/candidate_fit.hpp"

#include "core/error.hpp"
#include "diagnose/best_fit.hpp"
#include "diagnose/fit_starts.hpp"

#include <utility>

namespace culm::diagnose {
namespace {

calibrate::ChainFitOptions fit_options(const CandidateOptions& options, bool is_first_guess) {
    calibrate::ChainFitOptions fit;
    fit.window = options.window;
    fit.is_first_guess = is_first_guess;
    fit.heartbeat = options.heartbeat;
    return fit;
}

void store(BestFit& best, CandidateFit& result) {
    result.starts = best.starts();
    result.runs = best.runs();
    if (std::optional<calibrate::JointFit> fit = best.take())
        result.fit = std::move(fit->parts.front());
    else
        result.failure = best.failure();
}

} // namespace

CandidateFit fit_baseline(const measure::Measurement& measurement,
                          const CandidateOptions& options) {
    CandidateFit result;
    result.names = {"baseline"};
    const calibrate::StemModel model = calibrate::baseline_model(measurement, options.chain);
    result.moves = measurement.release != measure::ReleaseKind::HeldStraight;
    result.starts = 1;
    if (result.moves) {
        BestFit best({&measurement, 1}, options);
        best.try_start({model}, true);
        store(best, result);
    } else {
        const std::vector<bool> all_held(model.free_count(), true);
        result.fit = calibrate::fit_chain_with_held(model, measurement, all_held,
                                                    fit_options(options, false));
        result.runs = result.fit->runs;
    }
    return result;
}

CandidateFit fit_candidate(const SelectedEffects& effects, const CandidateFit& smaller,
                           const measure::Measurement& measurement,
                           const CandidateOptions& options) {
    CandidateFit result;
    result.names = model_names(in_library_order(effects));
    const calibrate::StemModel baseline = calibrate::baseline_model(measurement, options.chain);
    const calibrate::StemModel model = candidate_model(baseline, effects, measurement);
    if (!smaller.fit) {
        result.failure = "the model that it contains could not be fitted: " + smaller.failure;
        return result;
    }
    if (!can_move(model, measurement)) {
        result = smaller;
        result.names = model_names(in_library_order(effects));
        result.moves = false;
        return result;
    }
    BestFit best({&measurement, 1}, options);
    if (smaller.moves) {
        std::vector<JointStart> starts;
        for (calibrate::StemModel& start : candidate_starts(model, *smaller.fit))
            starts.push_back({std::move(start)});
        best.try_larger(starts, std::nullopt, {&*smaller.fit, 1}, is_nested(model));
    } else {
        best.try_start({model}, true);
    }
    store(best, result);
    return result;
}

} // namespace culm::diagnose
