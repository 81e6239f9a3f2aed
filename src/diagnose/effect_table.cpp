// SPDX-License-Identifier: BSD-3-Clause
#include "diagnose/effect_table.hpp"

#include "core/error.hpp"
#include "fit/solve/reading_errors.hpp"
#include "fit/solve/residual_statistics.hpp"

namespace culm::diagnose {
namespace {

EffectCell cell_of(const fit::ModelFit& model) {
    EffectCell cell;
    cell.runs = model.judged.runs;
    if (model.judged.failed()) {
        cell.failure = model.judged.reason;
        return cell;
    }
    const fit::RecordingFit& fit = model.stated.parts.front();
    cell.rmse = fit.rmse;
    cell.over_noise = fit::over_noise(fit);
    cell.reduced_chi_squared = model.judged.reduced_chi_squared;
    for (const fit::FittedParameter& parameter : fit.parameters) {
        if (!parameter.id.is_of_effect())
            continue;
        cell.parameters.push_back(parameter);
        cell.is_at_bound = cell.is_at_bound || parameter.is_at_bound;
    }
    return cell;
}

} // namespace

EffectCell EffectTable::cell(std::size_t measurement, const fit::SelectedEffects& effects,
                             const run::Heartbeat& heartbeat) {
    const measure::Measurement& measured = measurements_[measurement];
    fit::FitOptions options = options_;
    options.heartbeat = heartbeat;
    EffectCell failed;
    try {
        auto baseline = baselines_.find(measurement);
        if (baseline == baselines_.end())
            baseline =
                baselines_.emplace(measurement, fit::fit_baseline({&measured, 1}, options)).first;
        if (effects.empty())
            return cell_of({baseline->second.stated, baseline->second.fit});
        (void)fit::candidate_model(fit::baseline_model(measured, options.chain), effects, measured);
        const std::vector<fit::ObservedRecording> exact =
            fit::with_inputs_as_stated(baseline->second.recordings);
        return cell_of(
            fit::judged_model(fit::fit_with_parts(effects, baseline->second.stated, exact, options),
                              baseline->second.recordings, options));
    } catch (const core::InputError& error) {
        failed.applies = false;
        failed.failure = error.what();
    } catch (const core::NumericalError& error) {
        failed.failure = error.what();
    }
    return failed;
}

} // namespace culm::diagnose
